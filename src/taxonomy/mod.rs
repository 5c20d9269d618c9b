//! taxonomy
/// Stub.
pub fn lookup(_code: &str) -> Result<(), String> {
    Ok(())
}
