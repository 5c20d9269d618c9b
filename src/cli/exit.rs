//! Exit codes, and how they follow from findings.

use crate::diagnostics::{Diagnostic, Severity, codes};
use crate::engine::files::LoadedFiles;
use crate::engine::pipeline::Verdict;

/// Exit code of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum ExitCode {
    /// No errors.
    Success = 0,
    /// Findings of severity error: an unrealizable contract, a violated rule, a failed validation.
    Findings = 1,
    /// The command could not run: bad arguments, an unreadable file, a file that does not parse, a
    /// missing compiler.
    CannotRun = 2,
    /// A limit was reached.
    GaveUp = 3,
    /// Internal error (LW007): the checked object has no verdict.
    Internal = 4,
}

impl ExitCode {
    /// The code for loaded files: `CannotRun` if a file of another tool yielded no specification.
    pub fn of_loading(loaded: &LoadedFiles) -> Self {
        if loaded.has_invalid_foreign() {
            Self::CannotRun
        } else {
            Self::Success
        }
    }

    /// The combined code: the first of 4, 2, 3, 1, 0 that occurs.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let rank = |code: Self| match code {
            Self::Success => 0,
            Self::Findings => 1,
            Self::GaveUp => 2,
            Self::CannotRun => 3,
            Self::Internal => 4,
        };
        if rank(other) > rank(self) {
            other
        } else {
            self
        }
    }

    /// The code for findings. With `deny_warnings`, a warning counts as an error. If a limit of the
    /// command was reached, the finding's severity does not matter.
    pub fn of(findings: &[Diagnostic], deny_warnings: bool) -> Self {
        findings
            .iter()
            .map(|finding| match finding.severity {
                _ if finding.gave_up => Self::GaveUp,
                Severity::Error => Self::of_error(finding),
                Severity::Warning if deny_warnings => Self::Findings,
                _ => Self::Success,
            })
            .fold(Self::Success, Self::and)
    }

    fn of_error(finding: &Diagnostic) -> Self {
        const CANNOT_RUN: [codes::Code; 14] = [
            codes::FILE_UNREADABLE,
            codes::SYNTAX,
            codes::IMPORT_MISSING,
            codes::LINE_LIMIT,
            codes::COMPILER_MISSING,
            codes::COMPILER_FAILED,
            codes::CROSS_COMPILER_MISSING,
            codes::MSVC_MISSING,
            codes::LIBRARY_DAMAGED,
            codes::OUTPUT_UNWRITABLE,
            codes::PROFILE,
            codes::DUMP,
            codes::FILE_KEPT,
            codes::DOCUMENT,
        ];
        if finding.code == codes::INTERNAL {
            Self::Internal
        } else if CANNOT_RUN.contains(&finding.code) {
            Self::CannotRun
        } else if finding.code == codes::GAVE_UP {
            Self::GaveUp
        } else {
            Self::Findings
        }
    }
}

impl From<Verdict> for ExitCode {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Realizable => Self::Success,
            Verdict::Unrealizable | Verdict::Invalid => Self::Findings,
            Verdict::GaveUp => Self::GaveUp,
            Verdict::InternalError => Self::Internal,
        }
    }
}

impl From<ExitCode> for std::process::ExitCode {
    fn from(code: ExitCode) -> Self {
        Self::from(code as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_combine_to_the_first_of_4_2_3_1() {
        use ExitCode::{CannotRun, Findings, GaveUp, Internal, Success};
        let order = [Success, Findings, GaveUp, CannotRun, Internal];
        for (i, a) in order.into_iter().enumerate() {
            for (j, b) in order.into_iter().enumerate() {
                assert_eq!(a.and(b), order[i.max(j)]);
            }
        }
    }

    #[test]
    fn exit_codes_follow_from_findings() {
        let error = |code| Diagnostic::error(code, None, "");
        let warning = Diagnostic::warning(codes::SYNTAX, None, "");
        let of = |findings: &[Diagnostic]| ExitCode::of(findings, false);
        assert_eq!(of(&[]), ExitCode::Success);
        assert_eq!(of(std::slice::from_ref(&warning)), ExitCode::Success);
        assert_eq!(ExitCode::of(&[warning], true), ExitCode::Findings);
        assert_eq!(of(&[error(codes::UNREALIZABLE)]), ExitCode::Findings);
        assert_eq!(
            of(&[error(codes::UNREALIZABLE), error(codes::GAVE_UP)]),
            ExitCode::GaveUp
        );
        assert_eq!(
            of(&[error(codes::SYNTAX), error(codes::GAVE_UP)]),
            ExitCode::CannotRun
        );
        assert_eq!(
            of(&[error(codes::SYNTAX), error(codes::INTERNAL)]),
            ExitCode::Internal
        );
    }
}
