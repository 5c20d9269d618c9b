//! The bundled discrete-event runner.
