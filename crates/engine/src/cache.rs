//! Cache of solved contracts and of proofs: an unchanged contract is not solved again, and an
//! unchanged machine or line is not proved again.
//!
//! There are three kinds of files. An *entry* is stored under a hash of everything that determines
//! the result of a contract: the specification without its source positions, the solver options,
//! and the program itself. A *proof* is stored likewise, under a hash of the claim. A *version* is
//! stored under a contract's name. It records the winning region and the final variable order of
//! the contract's last large game; both are used once the contract has changed.
//!
//! Every file is written atomically, can be deleted at any time, and is ignored if its checksum
//! does not match. Failures to write are ignored. Entries hold results but no messages, so that
//! findings point to the right place after a contract has moved within its file.

use super::controller::ExtractionOptions;
use super::pipeline::Explanation;
use super::statistics::Statistics;
use linewright_core::gr1::{Expr, Formula, Specification, Variable};
use linewright_solver::game::{
    BudgetFactor, Diagram, DiagramNode, Edge, EnvironmentFindings, GuaranteeRef, Heuristic,
    KernelChoice, Limits, Order, WeaknessFindings,
};
use linewright_solver::mealy::{self, functions::Functions};
use linewright_solver::symbolic::Bit;
use linewright_station::disk;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Once;
use std::time::SystemTime;

/// Identifies the program that makes the entries: its version and a hash of its sources.
const PROGRAM: &str = concat!(env!("CARGO_PKG_VERSION"), " ", env!("LINEWRIGHT_SOURCES"));

/// Maximum size of the folder in bytes. Beyond it, the oldest files are deleted until half of this
/// size is left.
const MAX_BYTES: u64 = 512 << 20;

/// The order of an earlier version is not improved before the search if one variable in this many
/// is new, or fewer.
const FEW_NEW: usize = 10;

/// Maximum number of BDD nodes of a stored winning region; a larger one is not stored.
const MAX_REGION_NODES: usize = 500_000;

/// A cache folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
}

/// Stored result of a contract.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Entry {
    /// Whether there is a controller.
    pub realizable: bool,
    /// For an unrealizable contract, the guarantees that clash; `None` if a limit was reached
    /// first.
    pub core: Option<Vec<GuaranteeRef>>,
    /// Checks that were made in addition to the verdict.
    pub examined: ExaminationDepth,
    /// Findings about the environment; `None` if it was not examined, or the game was too large.
    pub environment: Option<EnvironmentFindings>,
    /// Formulas that demand less than they seem to; `None` if not examined, or the game was too
    /// large.
    pub shape: Option<WeaknessFindings>,
    /// For an unrealizable contract, the explanation of why no controller exists, if it was
    /// computed.
    pub lost: Option<Box<Explanation>>,
    /// Whether a controller was requested.
    pub extracted: bool,
    /// The verified controller as a machine; `None` if not requested, or too large for a machine.
    pub machine: Option<mealy::Machine>,
    /// The certified controller as functions, if it has this form.
    pub functions: Option<Box<Functions>>,
    /// Peak number of BDD nodes.
    pub peak_nodes: u64,
    /// Statistics of the solver.
    pub statistics: Statistics,
}

/// Nodes of a winning region as (bit, high edge, low edge), and the edge to the root.
type Region = (Vec<(u16, u32, u32)>, u32);

/// Checks of a contract that were made in addition to its verdict.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ExaminationDepth {
    /// No checks.
    Nothing,
    /// The environment only.
    Plant,
    /// The environment, and the formulas that may demand less than they seem to.
    Whole,
}

/// Stored data of the last solved version of a contract.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Version {
    /// Hash of the variables and of the timing (Mealy or Moore).
    variables: String,
    /// Names of the variables from the top of the diagrams to the bottom.
    order_of_variables: Vec<String>,
    /// Pairs of bits from top to bottom.
    order: Vec<u16>,
    /// Hashes of the formulas that the winning region depends on.
    formulas: Formulas,
    /// The winning region, if it was small enough to be stored.
    region: Option<Region>,
}

/// Hashes of the formulas that a winning region depends on: all except initial conditions.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Formulas {
    assumed_invariants: BTreeSet<String>,
    assumed_safety: BTreeSet<String>,
    assumed_justice: BTreeSet<String>,
    invariants: BTreeSet<String>,
    safety: BTreeSet<String>,
    justice: BTreeSet<String>,
}

/// Results of an earlier version of a contract, from which solving the current version can start.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Hints {
    /// Variable order to start with.
    pub order: Option<Order>,
    /// Whether the order is for the same variables, or nearly: then it is not improved before the
    /// search, which costs more than it is worth.
    pub is_final: bool,
    /// A set of states that contains the winning region.
    pub region: Option<Diagram>,
}

/// The options that an entry depends on.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// BDD kernel.
    pub kernel: KernelChoice,
    /// Enabled heuristics.
    pub heuristics: &'a [Heuristic],
    /// Memory limit in MiB.
    pub memory_mib: Option<u64>,
    /// Factor for the work that may be done to explain a verdict.
    pub budget_factor: BudgetFactor,
    /// Requested properties of the controller.
    pub extraction: ExtractionOptions,
}

/// Hash under which an entry is stored; it is part of the entry's file name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Key(String);

impl Key {
    /// Computes the key of a specification.
    pub fn new(specification: &Specification, options: &Options<'_>) -> Self {
        let mut feed = Feed::new("entry");
        let _ = write!(feed, "{options:?}");
        feed.variables(specification);
        for side in [&specification.assumptions, &specification.guarantees] {
            for list in [&side.initial, &side.invariants, &side.safety, &side.justice] {
                feed.list(list.iter().map(|f| &f.expr));
            }
        }
        Self(feed.finish())
    }

    /// Computes the key of a claim to be proved within these limits. `kind` tells apart questions
    /// about the same claim.
    pub fn of_proof(kind: &str, claim: &impl fmt::Debug, limits: &Limits) -> Self {
        let Limits {
            deadline: _,
            memory_mib,
            max_nodes,
            max_created,
            max_work,
            budget_factor,
        } = limits;
        let limits = (memory_mib, max_nodes, max_created, max_work, budget_factor);
        let mut feed = Feed::new("proof");
        let _ = write!(feed, "{kind}\n{claim:?}\n{limits:?}");
        Self(feed.finish())
    }
}

/// A hasher that accepts formatted text.
struct Feed(Sha256);

impl fmt::Write for Feed {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text);
        Ok(())
    }
}

impl Feed {
    fn new(what: &str) -> Self {
        let mut feed = Self(Sha256::new());
        let _ = write!(feed, "{what}\n{PROGRAM}\n");
        feed
    }

    /// Hashes everything about the variables except their source positions.
    fn variables(&mut self, specification: &Specification) {
        let _ = writeln!(self, "{:?}", specification.timing);
        for v in &specification.variables {
            let Variable {
                name,
                owner,
                internal,
                domain,
                unit,
                span: _,
            } = v;
            let _ = writeln!(self, "{name:?} {owner:?} {internal} {domain:?} {unit}");
        }
    }

    fn list<'a>(&mut self, expressions: impl Iterator<Item = &'a Expr>) {
        for expression in expressions {
            let _ = writeln!(self, "{expression:?}");
        }
        let _ = writeln!(self, "end");
    }

    fn finish(self) -> String {
        hex(&self.0.finalize())
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

impl Formulas {
    fn of(specification: &Specification) -> Self {
        let hashes = |list: &[Formula]| -> BTreeSet<String> {
            let hash = |f: &Formula| {
                let mut feed = Feed::new("formula");
                feed.list(std::iter::once(&f.expr));
                feed.finish()
            };
            list.iter().map(hash).collect()
        };
        let (a, g) = (&specification.assumptions, &specification.guarantees);
        Self {
            assumed_invariants: hashes(&a.invariants),
            assumed_safety: hashes(&a.safety),
            assumed_justice: hashes(&a.justice),
            invariants: hashes(&g.invariants),
            safety: hashes(&g.safety),
            justice: hashes(&g.justice),
        }
    }

    /// Whether the winning region for these formulas is certain to contain the winning region for
    /// `new`.
    ///
    /// Let `F(Z) = ⋀ⱼ μY. ⋁ᵢ νX. Z ∧ CPre((Gⱼ ∧ Z′) ∨ Y′ ∨ (¬Aᵢ ∧ X′))`. The winning region is the
    /// greatest fixpoint of `F` within the legal states S. If `F′(Z) ⊆ F(Z)` for all Z, and `S′ ⊆
    /// S`, then `νF′ = F′(νF′) ⊆ F(νF′)`, so `νF′ ⊆ νF`. This holds when
    ///
    /// - the assumed invariants are the same and every guaranteed invariant remains: `S′ ⊆ S`. With
    ///   fewer assumed invariants there would be new states, about which nothing is known;
    /// - no assumed safety is new: the plant can do everything it could before, so `∀x′. ρe → …`
    ///   became harder to satisfy;
    /// - every guaranteed safety remains: the machine can do at most what it could before, so `∃y′.
    ///   ρs ∧ …` became harder to satisfy;
    /// - no assumed justice is new: `⋁ᵢ` ranges over a subset. The empty list means `Aᵢ = true`,
    ///   which makes `νX` smaller than any other assumption does;
    /// - every guaranteed justice remains: `⋀ⱼ` ranges over a superset. The empty list means
    ///   `Gⱼ = true`, which makes `μY` larger than any other goal does.
    ///
    /// Initial conditions only decide whether the region is large enough. Searching from `S′ ∧ νF`
    /// instead of `S′` ends in the same region: every step maps a set that contains `νF′` to
    /// another such set, no step enlarges the set, and a set that no step changes is a fixpoint of
    /// `F′`, hence within `νF′`.
    fn contain_regions_of(&self, new: &Self) -> bool {
        self.assumed_invariants == new.assumed_invariants
            && new.assumed_safety.is_subset(&self.assumed_safety)
            && new.assumed_justice.is_subset(&self.assumed_justice)
            && self.invariants.is_subset(&new.invariants)
            && self.safety.is_subset(&new.safety)
            && self.justice.is_subset(&new.justice)
    }
}

/// Hash of the variables and of the timing (Mealy or Moore).
fn variables(specification: &Specification) -> String {
    let mut feed = Feed::new("variables");
    feed.variables(specification);
    feed.finish()
}

impl Version {
    /// Records the version of a solved specification.
    pub fn new(
        specification: &Specification,
        order: &Order,
        order_of_variables: &[String],
        region: Option<Diagram>,
    ) -> Self {
        let region = region.filter(|r| r.nodes.len() <= MAX_REGION_NODES && r.roots.len() == 1);
        Self {
            variables: variables(specification),
            order_of_variables: order_of_variables.to_vec(),
            order: order.pairs().to_vec(),
            formulas: Formulas::of(specification),
            region: region.map(|r| {
                let nodes = r.nodes.iter().map(|n| (n.bit.0, n.high.0, n.low.0));
                (nodes.collect(), r.roots[0].0)
            }),
        }
    }

    /// Returns the results with which solving `specification` can start. The solver checks the
    /// region itself and uses it only if it fits.
    pub fn hints(&self, specification: &Specification) -> Hints {
        if self.variables != variables(specification) {
            return self.order_by_name(specification);
        }
        let sound = self
            .formulas
            .contain_regions_of(&Formulas::of(specification));
        Hints {
            order: Order::new(self.order.clone()),
            is_final: true,
            region: self.region.as_ref().filter(|_| sound).map(|(nodes, root)| {
                let nodes = nodes.iter().map(|(bit, high, low)| DiagramNode {
                    bit: Bit(*bit),
                    high: Edge(*high),
                    low: Edge(*low),
                });
                Diagram {
                    nodes: nodes.collect(),
                    roots: vec![Edge(*root)],
                }
            }),
        }
    }

    /// Variable order by the names that both versions share; each new variable follows the variable
    /// declared before it. No order if fewer than half of the variables are shared.
    fn order_by_name(&self, specification: &Specification) -> Hints {
        let places: BTreeMap<&str, usize> = self
            .order_of_variables
            .iter()
            .enumerate()
            .map(|(place, name)| (name.as_str(), place))
            .collect();
        let variables = &specification.variables;
        let is_new = |v: &&Variable| !places.contains_key(v.name.as_str());
        let new = variables.iter().filter(is_new).count();
        if new * 2 > variables.len() {
            return Hints::default();
        }
        let mut ranked = Vec::new();
        let mut last = 0;
        for (index, variable) in variables.iter().enumerate() {
            last = *places.get(variable.name.as_str()).unwrap_or(&last);
            ranked.push((last, index));
        }
        ranked.sort_unstable();
        let ranked = ranked.into_iter().map(|(_, i)| i);
        Hints {
            order: linewright_solver::game::order_from_variables(specification, ranked),
            is_final: new * FEW_NEW <= variables.len(),
            region: None,
        }
    }
}

impl Cache {
    /// Uses the folder named by `LINEWRIGHT_CACHE`, or else one in the user's cache folder. `None`
    /// if the environment variable is `off`, or the user has no cache folder.
    pub fn of_user() -> Option<Self> {
        let named = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty());
        if let Some(folder) = named("LINEWRIGHT_CACHE") {
            return (folder != "off").then(|| Self::in_folder(folder));
        }
        let absolute = |name: &str| named(name).map(PathBuf::from).filter(|p| p.is_absolute());
        let caches = if cfg!(windows) {
            absolute("LOCALAPPDATA")
        } else if cfg!(target_os = "macos") {
            absolute("HOME").map(|home| home.join("Library/Caches"))
        } else {
            absolute("XDG_CACHE_HOME").or_else(|| absolute("HOME").map(|home| home.join(".cache")))
        };
        caches.map(|caches| Self::in_folder(caches.join("linewright")))
    }

    /// Uses the given folder, which is created at the first write.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
        }
    }

    /// Path of the cache folder.
    pub fn folder(&self) -> &std::path::Path {
        &self.folder
    }

    /// Reads the entry of a key, if there is one.
    pub fn find(&self, key: &Key) -> Option<Entry> {
        self.read(&format!("entry-{}", key.0))
    }

    /// Stores an entry.
    pub fn store(&self, key: &Key, entry: &Entry) {
        self.write(&format!("entry-{}", key.0), entry);
    }

    /// Reads the answer to a question about a claim, if it is stored.
    pub fn answer<T: DeserializeOwned>(&self, key: &Key) -> Option<T> {
        self.read(&format!("proof-{}", key.0))
    }

    /// Stores the answer to a question about a claim.
    pub fn store_answer<T: Serialize>(&self, key: &Key, answer: &T) {
        self.write(&format!("proof-{}", key.0), answer);
    }

    /// Reads the last version of the contract with this specification's name.
    pub fn version(&self, specification: &Specification) -> Option<Version> {
        self.read(&Self::version_name(specification))
    }

    /// Stores a version of a contract and replaces the previous one.
    pub fn store_version(&self, specification: &Specification, version: &Version) {
        self.write(&Self::version_name(specification), version);
    }

    fn version_name(specification: &Specification) -> String {
        let mut feed = Feed::new("version");
        let _ = write!(feed, "{:?}", specification.name);
        format!("version-{}", feed.finish())
    }

    /// Reads a file if its first line is the checksum of its name and the remaining content.
    fn read<T: DeserializeOwned>(&self, name: &str) -> Option<T> {
        let bytes = disk::read(&self.folder.join(name)).ok()?;
        let end = bytes.iter().position(|b| *b == b'\n')?;
        let (sum, rest) = (&bytes[..end], &bytes[end + 1..]);
        if sum != checksum(name, rest).as_bytes() {
            return None;
        }
        serde_json::from_slice(rest).ok()
    }

    fn write<T: Serialize>(&self, name: &str, content: &T) {
        static TIDIED: Once = Once::new();
        // If writing fails, the next run solves again.
        let _ = self.try_write(name, content);
        TIDIED.call_once(|| {
            let _ = tidy(&self.folder, MAX_BYTES);
        });
    }

    fn try_write<T: Serialize>(&self, name: &str, content: &T) -> std::io::Result<()> {
        std::fs::create_dir_all(&self.folder)?;
        let rest = serde_json::to_vec(content)?;
        let mut file = tempfile::Builder::new()
            .prefix(".new-")
            .tempfile_in(&self.folder)?;
        writeln!(file, "{}", checksum(name, &rest))?;
        file.write_all(&rest)?;
        file.persist(self.folder.join(name))?;
        Ok(())
    }
}

/// Checksum of a file's name and content. The name is included so that a file copied over another
/// one is detected.
fn checksum(name: &str, content: &[u8]) -> String {
    let mut hash = Sha256::new_with_prefix(name);
    hash.update(content);
    hex(&hash.finalize())
}

/// If the folder is larger than `max` bytes, deletes the oldest files, including temporary files of
/// killed runs, until at most half of `max` is left.
fn tidy(folder: &Path, max: u64) -> std::io::Result<()> {
    let mut files: Vec<(SystemTime, u64, PathBuf)> = Vec::new();
    for file in std::fs::read_dir(folder)? {
        let file = file?;
        let name = file.file_name();
        let name = name.to_string_lossy();
        if ["entry-", "proof-", "version-", ".new-"]
            .iter()
            .any(|p| name.starts_with(p))
        {
            let about = file.metadata()?;
            files.push((about.modified()?, about.len(), file.path()));
        }
    }
    files.sort();
    let mut total: u64 = files.iter().map(|f| f.1).sum();
    if total <= max {
        return Ok(());
    }
    for (_, length, path) in files {
        if total <= max / 2 {
            break;
        }
        std::fs::remove_file(path)?;
        total -= length;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry() -> Entry {
        Entry {
            shape: None,
            lost: None,
            realizable: true,
            core: None,
            examined: ExaminationDepth::Whole,
            environment: None,
            extracted: false,
            machine: None,
            functions: None,
            peak_nodes: 17,
            statistics: Statistics::default(),
        }
    }

    #[test]
    fn a_stored_entry_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path().join("a/b"));
        let key = Key("1".to_owned());
        assert!(cache.find(&key).is_none());
        cache.store(&key, &entry());
        assert_eq!(cache.find(&key).unwrap().peak_nodes, 17);
        assert!(cache.find(&Key("2".to_owned())).is_none());
    }

    #[test]
    fn a_damaged_file_is_not_read() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path());
        let key = Key("1".to_owned());
        cache.store(&key, &entry());
        let path = folder.path().join("entry-1");
        let whole = std::fs::read(&path).unwrap();
        for damaged in [
            &whole[..whole.len() - 1],
            &whole[..10],
            &[],
            &[&whole[..], b" "].concat(),
            &String::from_utf8(whole.clone())
                .unwrap()
                .replace("17", "18")
                .into_bytes(),
        ] {
            std::fs::write(&path, damaged).unwrap();
            assert!(cache.find(&key).is_none());
        }
        cache.store(&key, &entry());
        assert!(cache.find(&key).is_some());
        // Intact, but it belongs to another contract.
        std::fs::copy(&path, folder.path().join("entry-2")).unwrap();
        assert!(cache.find(&Key("2".to_owned())).is_none());
    }

    #[test]
    fn failures_to_write_are_ignored() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "mine").unwrap();
        let cache = Cache::in_folder(&file);
        cache.store(&Key("1".to_owned()), &entry());
        assert!(cache.find(&Key("1".to_owned())).is_none());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "mine");
    }

    #[test]
    fn the_oldest_files_are_deleted_first() {
        let folder = tempfile::tempdir().unwrap();
        let now = SystemTime::now();
        for (name, age) in [
            ("entry-1", 30),
            ("entry-2", 20),
            ("version-3", 10),
            ("other", 40),
        ] {
            let path = folder.path().join(name);
            std::fs::write(&path, [0; 100]).unwrap();
            let file = std::fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(now - std::time::Duration::from_secs(age))
                .unwrap();
        }
        tidy(folder.path(), 300).unwrap();
        assert!(folder.path().join("entry-1").exists());
        tidy(folder.path(), 299).unwrap();
        let left = |name: &str| folder.path().join(name).exists();
        let names = ["entry-1", "entry-2", "version-3", "other"];
        assert_eq!(names.map(left), [false, false, true, true]);
    }
}
