//! Sketches, drawn with text, of the pictures that commands write. They stand at the end of
//! `--help`; the guide has the pictures themselves.

/// The report of a run.
pub const RUN: &str = "\
A report (--report) has the line as a picture in which the run is played, and charts:

    water ─▶ filler ─▶ capper ─▶ packer ─▶ dispatch     ▶ Play   2:14:05
             ●         ●         ■ 12/20

    filler   ████████████████████████▓▓▓▓░░░░  70 %     █ busy
    capper   ██████████████░░░░░░░░░░░░░░░░░░  42 %     ▓ failed
    packer   ███████░░░░░░░░░░░░░░░░░░░░░░░░░  20 %     ░ starved

    work in progress  ▁▂▄▅▅▆▅▅▇▆▅▅▆▅▅▄    lead times  ▂▆█▇▅▃▂▂▁▁▁

The guide shows one in its chapter on reports.";

/// The report of a check.
pub const CHECK: &str = "\
A report (--report) has the verdicts, and shows as a timing diagram how the plant wins:

    ✓ Turn    realizable            step               0     1
    ✗ Answer  unrealizable          plant    request   ▔▔▔▔▔▔▔▔▔▔▔▔
      clash:  at_once, rest         machine  running   ▔▔▔▔▔▔?

The guide shows one in its chapter on reports.";

/// The report of a controller.
pub const SYNTH: &str = "\
A report (--report) and the format svg show the states; in a report you choose inputs and walk:

        ┌────────┐  job   ┌─────────┐  executed  ┌──────┐
    ──▶ │ S0     │ ─────▶ │ S1      │ ─────────▶ │ S2   │
        │ (idle) │        │ command │            │ done │
        └────────┘ ◀──────└─────────┘            └──────┘

The guide shows them in its chapters on reports and drawings.";

/// The timing diagram of a play.
pub const STEP: &str = "\
A saved page (--html) and `save play.svg` show the play as a timing diagram:

    step      0     1     2     3
    turning   ▁▁▁▁▁▁▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔▔
    angle     ⟨ 0  ⟩⟨ 1  ⟩⟨ 2        ⟩

The guide shows one in its chapter on playing a contract.";

/// The drawing of a machine.
pub const DRAW: &str = "\
A drawing of a machine, for example, shows its components with their wires:

    ┌─────────────┐  command   ┌──────┐
    │ Coordinator │ ─────────▶ │ Turn │
    │             │ ◀───────── │      │
    └─────────────┘  executed  └──────┘

The guide shows all kinds in its chapter on drawings.";

/// The end of a command's `--help`: its examples, and a sketch of what it shows.
pub fn below(examples: &str, picture: &str) -> String {
    format!("{examples}\n\n{picture}")
}
