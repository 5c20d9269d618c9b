//! Every diagnostic code, with its title.
//!
//! The first digit gives the topic of a code: see [`GROUPS`]. A code is never reused for something
//! else. Each code has a page in `crates/core/src/diagnostics/explanations/`, shown by
//! `linewright explain`.

/// A diagnostic code.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Code {
    /// Identifier, such as `LW101`.
    pub id: &'static str,
    /// Short description of the problem, a few words.
    pub title: &'static str,
}

impl std::fmt::Display for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id)
    }
}

impl Code {
    /// Returns the group of the code.
    ///
    /// # Panics
    /// Panics if no group has the first digit of the code. A test checks that every code has a
    /// group.
    pub fn group(self) -> &'static Group {
        let start = |g: &&Group| g.pattern[..3] == self.id[..3];
        GROUPS.iter().find(start).expect("every code has a group")
    }
}

/// Codes with the same first digit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Group {
    /// Pattern of its ids, such as `LW1xx`.
    pub pattern: &'static str,
    /// Topic of its codes.
    pub title: &'static str,
}

/// All groups in ascending order.
pub const GROUPS: &[Group] = &[
    Group::new("LW0xx", "source and syntax"),
    Group::new("LW1xx", "types and names"),
    Group::new("LW2xx", "game"),
    Group::new("LW3xx", "machine and composition"),
    Group::new("LW4xx", "line"),
    Group::new("LW5xx", "station"),
    Group::new("LW6xx", "layout and recipe"),
];

impl Group {
    const fn new(pattern: &'static str, title: &'static str) -> Self {
        Self { pattern, title }
    }

    /// Returns the codes of the group in ascending order.
    pub fn codes(&'static self) -> impl Iterator<Item = Code> {
        ALL.iter().copied().filter(move |c| c.group() == self)
    }
}

macro_rules! codes {
    ($($(#[$doc:meta])* $name:ident = $id:literal, $title:literal;)*) => {
        $($(#[$doc])* #[doc = $title] pub const $name: Code = Code { id: $id, title: $title };)*

        /// All codes in ascending order.
        pub const ALL: &[Code] = &[$($name),*];
    };
}

codes! {
    FILE_UNREADABLE = "LW001", "a file cannot be read";
    SYNTAX = "LW002", "a declaration or formula does not follow the grammar";
    IMPORT_CIRCULAR = "LW003", "files import each other (circular import)";
    IMPORT_MISSING = "LW004", "an imported file does not exist";
    NOTATION = "LW005", "another tool's notation means something unusual";
    OWN_TOOL = "LW006", "the tool of a file's format gives another answer";
    INTERNAL = "LW007", "linewright itself failed";

    NAME_UNKNOWN = "LW101", "a name is not declared";
    NAME_DUPLICATE = "LW102", "a name is declared twice";
    TYPE_MISMATCH = "LW103", "a type does not fit";
    DOMAIN_EMPTY = "LW104", "a domain is empty or too large";
    ARGUMENT = "LW105", "an argument is missing, unknown or outside its range";
    NOT_CONSTANT = "LW106", "a constant is needed";
    INDEX_RANGE = "LW107", "an array index is out of bounds";
    DIVISION = "LW108", "a divisor can be zero";
    TAXONOMY_UNKNOWN = "LW109", "a taxonomy code does not exist";
    NUMBER_RANGE = "LW110", "a number is too large";
    UNUSED = "LW111", "a declaration is never used";
    TOO_LARGE = "LW112", "a formula becomes too large";
    NAMES_ALIKE = "LW113", "two names might mean the same thing";
    COMPARISON_DECIDED = "LW114", "a comparison is always true or always false";
    SKILL = "LW115", "a skill does not fit its component or its order";

    NOT_GR1 = "LW201", "a formula is outside GR(1)";
    NOT_CONTROLLED = "LW202", "a formula constrains what its side does not control";
    UNREALIZABLE = "LW203", "no controller can keep the guarantees";
    GAVE_UP = "LW204", "a limit was reached before there was a verdict";
    NOT_WELL_SEPARATED = "LW205", "the machine can win by breaking the assumptions";
    ENVIRONMENT_EMPTY = "LW206", "no environment keeps the assumptions";
    NEXT_NESTED = "LW207", "`next` is nested in `next`";
    DOMAIN_LEFT = "LW208", "a next value can leave its domain";
    NEXT_OUTPUT_ASSUMED = "LW209", "an assumption refers to the machine's next values";
    PAST = "LW210", "an operator over other steps is out of place";
    NEXT_BOTH_SIDES = "LW211", "`next` appears on both sides of an equation";
    UNBREAKABLE = "LW212", "a guarantee cannot be broken";
    CONDITION_NEVER_HOLDS = "LW213", "the condition of a formula never holds";
    UNCONSTRAINED = "LW214", "no guarantee restricts an output";
    CONSTANT = "LW215", "an output keeps one value for ever";
    UNFRAMED = "LW216", "an output is unconstrained where it was probably meant to stay";
    REQUEST_BY_CHANCE = "LW217", "a request might never be completed, whatever the controller does";
    REQUEST_OPEN = "LW218", "no guarantee requires that a request is completed";
    IDLE = "LW219", "a machine that never changes its outputs keeps the contract";

    INPUT_UNBOUND = "LW301", "an input of a component is not bound";
    SAME_STEP_LOOP = "LW302", "components wait for each other in the same step";
    ASSUMPTION_UNDISCHARGED = "LW303", "an assumption is not discharged";
    REQUEST_INCOMPLETE = "LW304", "an accepted request might never complete";
    OPERATION = "LW306", "an operation or a station does not fit its machine";
    COORDINATOR_KIND = "LW307", "a coordinator must be a moore contract";
    PROPERTY = "LW308", "a property of the part is used wrongly";
    JUSTICE_CYCLE = "LW309", "justice assumptions depend on one another";
    GUARANTEE_UNPROVED = "LW310", "a guarantee of the whole does not follow from its components";
    PORTS = "LW311", "the ports of contracts do not fit together";
    INCOMPATIBLE = "LW312", "no environment fits the contracts";
    MACHINE_IN_ITSELF = "LW313", "a machine contains itself";
    ORDER_EMPTY = "LW314", "rules of a skill order allow nothing";
    ORDER_CONTRADICTION = "LW315", "rules of a skill order contradict each other";
    ORDER_REDUNDANT = "LW316", "a rule of a skill order excludes nothing";
    ORDER_BROKEN = "LW317", "a program breaks a rule of a skill order";

    LINE_UNKNOWN = "LW401", "a station, part type or route end is not declared";
    LINE_ROUTE = "LW402", "a part has no way onward";
    LINE_BLOCKED = "LW403", "the line can no longer advance";
    LINE_LIMIT = "LW404", "a run has no end, or is too short";
    LINE_VIOLATION = "LW405", "a contract was violated while the line ran";
    LINE_REQUIREMENT = "LW406", "a requirement does not hold";
    LINE_PART_LOST = "LW407", "a conveyor lost or doubled a part";
    LINE_CYCLE = "LW408", "parts can deadlock (circular wait)";
    LINE_UNFINISHED = "LW409", "an order might stay unfinished for ever";
    LINE_UNDECIDED = "LW410", "a line is too large to be proved";
    LINE_FORBIDDEN_REQUEST = "LW411", "a line can request what a machine forbids";
    LINE_REFUSED = "LW414", "a station refuses a part";
    LINE_VALUE = "LW415", "a value leaves its range";
    LINE_TIMELESS = "LW416", "parts move without any time passing";
    LINE_TABLE = "LW417", "a table of times cannot be used";

    COMPILER_MISSING = "LW501", "no C compiler was found";
    COMPILER_FAILED = "LW502", "the C compiler failed";
    LIBRARY_DAMAGED = "LW503", "a station library is damaged";
    OUTPUT_UNWRITABLE = "LW504", "a file or folder cannot be written";
    LIBRARY_CALL = "LW505", "a station library returned an error";
    CROSS_COMPILER_MISSING = "LW506", "no C compiler for Windows was found";
    MSVC_MISSING = "LW507", "Microsoft's compiler was not found";

    UNIT_WITHOUT_BINARY = "LW530", "an FMI unit lacks a binary";

    PROFILE = "LW540", "a profile of UF_Value is wrong";
    PROFILE_UNVERIFIED = "LW541", "a profile of UF_Value is unverified";
    PROFILE_FOREIGN = "LW542", "a station library is built for another layout of UF_Value";
    DUMP = "LW543", "a probe's dump is damaged or incomplete";
    LAYOUT_UNDETERMINED = "LW544", "a probe's dump does not determine the layout of UF_Value";
    LAYOUT_REFUTED = "LW545", "the host did not read back what was returned";
    FILE_KEPT = "LW546", "a file already exists and differs";
    LINE_SIZES = "LW547", "a machine is built with the sizes that a line gives it";

    LAYOUT_STUCK = "LW601", "a resource never enters a state, or can get stuck in it";
    LAYOUT_PARTNER = "LW602", "a transfer has no partner";
    LAYOUT_CAPACITY = "LW603", "a resource holds more parts than it has room for";
    LAYOUT_ROUTE = "LW604", "a route does not fit the resources that it joins";
    RECIPE_GRAPH = "LW605", "a recipe does not lead from its start to an end";
    RECIPE_GUARDS = "LW606", "the guards of a recipe do not cover every outcome once";
    RECIPE_OPERATION = "LW607", "no resource performs an operation of a recipe";
    RECIPE_PART = "LW608", "an operation needs a part that is not there";
    RECIPE_WAY = "LW609", "a part cannot get to where it is needed";
    RECIPE_ROOM = "LW610", "a resource has no room for a part";
    RECIPE_PARALLEL = "LW611", "parallel operations need different resources";
    RECIPE_WAIT = "LW612", "a resource would have to wait where it may not";
    RECIPE_LEFTOVER = "LW613", "a part would remain in the cell";
    RECIPE_UNREALIZABLE = "LW614", "a recipe cannot be made on a layout";
    RECIPE_UNDECIDED = "LW615", "it is not decided whether a recipe can be made";

    DOCUMENT = "LW620", "a B2MML document cannot be imported";
    DOCUMENT_LEFT_OUT = "LW621", "an element of a B2MML document is left out";
}

/// Returns the code with an id such as `LW101`; case does not matter.
pub fn find(id: &str) -> Option<Code> {
    ALL.iter().copied().find(|c| c.id.eq_ignore_ascii_case(id))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_is_in_the_group_of_its_first_digit() {
        let grouped: Vec<Code> = GROUPS.iter().flat_map(Group::codes).collect();
        assert_eq!(grouped, ALL, "also: codes are in ascending order");
        assert!(GROUPS.iter().all(|g| g.codes().next().is_some()));
    }
}
