//! A monitor of skill orders as C99: a header and a source file without dependencies, allocation or recursion.

use crate::emit::Names;
use crate::emit::controller::Files;
use crate::emit::text::{comment, string, wrap};
use crate::emit::words::word;
use linewright_language::order::layout::Layout;
use linewright_language::order::monitor::Why;
use linewright_language::order::table::Table;
use std::fmt::Write;

/// The monitor of a table: `PickAndPlaceUnit_order.h` and `PickAndPlaceUnit_order.c`.
pub fn files(table: &Table) -> Files {
    let text = Text::new(table);
    Files {
        header: text.header(),
        source: text.source(),
        name: text.name,
    }
}

struct Text<'a> {
    table: &'a Table,
    layout: Layout,
    /// What everything that is declared begins with.
    name: String,
    /// The constants of the skills.
    skills: Vec<String>,
    /// The constants of the rules.
    rules: Vec<String>,
}

impl<'a> Text<'a> {
    fn new(table: &'a Table) -> Self {
        let own = word(&table.name);
        let name = format!("{own}_order");
        let mut names = Names::default();
        let mut constants = |prefix: &str, of: &mut dyn Iterator<Item = &String>| {
            of.map(|n| names.unique(&format!("{prefix}_{}", identifier(n))))
                .collect()
        };
        Self {
            skills: constants(&format!("{own}_skill"), &mut table.skills.iter()),
            rules: constants(
                &format!("{own}_rule"),
                &mut table.rules.iter().map(|r| &r.name),
            ),
            layout: Layout::new(table),
            table,
            name,
        }
    }

    /// What stands at the beginning of both files.
    fn about(&self, more: &str) -> String {
        let mut out = format!(
            "/* {}\n",
            wrap(
                &format!(
                    "The skill orders of {} {}, as a monitor made by linewright.",
                    comment(&self.table.name),
                    self.table.kept
                ),
                " * "
            )
        );
        if !self.table.rules.is_empty() {
            out.push_str(" *\n");
        }
        for rule in &self.table.rules {
            let line = wrap(&comment(&rule.to_string()), " *       ");
            let _ = writeln!(out, " *   {line}");
        }
        out + more + " */\n"
    }

    fn header(&self) -> String {
        let name = &self.name;
        let guard = format!("LINEWRIGHT_{name}_H");
        let mut out = self.about(&format!(
            " *\n * {}\n",
            wrap(
                "Tell it every call of a skill before the call is made. It is an interlock: a call that is refused must not be made, and \
                 changes nothing. A monitor belongs to one thread at a time.",
                " * "
            )
        ));
        let _ = write!(
            out,
            "#ifndef {guard}\n#define {guard}\n\n#include <stddef.h>\n#include <stdint.h>\n\n\
             #ifdef __cplusplus\nextern \"C\" {{\n#endif\n\n/* The skills. */\nenum {{\n"
        );
        for (number, skill) in self.skills.iter().enumerate() {
            let _ = writeln!(out, "    {skill} = {number},");
        }
        let _ = write!(
            out,
            "    {name}_SKILLS = {}\n}};\n\n\
             /* Several skills that are called at once: {name}_MASK(a) | {name}_MASK(b). */\n\
             #define {name}_MASK(skill) ((uint64_t)1 << (skill))\n\n\
             /* What a call is answered with. What is negative refuses it. */\nenum {{\n    {name}_ALLOWED = 0,\n",
            self.skills.len()
        );
        for (number, (rule, of)) in self.rules.iter().zip(&self.table.rules).enumerate() {
            let about = wrap(&format!("/* {} */", comment(&of.to_string())), "     * ");
            let _ = writeln!(
                out,
                "    {about}\n    {rule} = {},",
                self.answer(Why::Rule(number))
            );
        }
        let others = [
            ("RECALL", Why::Recall),
            ("TOGETHER", Why::Together),
            ("UNKNOWN", Why::Unknown),
        ];
        for (at, (constant, why)) in others.into_iter().enumerate() {
            let comma = if at + 1 < others.len() { "," } else { "" };
            let _ = writeln!(
                out,
                "    /* {} */\n    {name}_{constant} = {}{comma}",
                comment(&why.text(&self.table.rules)),
                self.answer(why)
            );
        }
        let _ = write!(
            out,
            "}};\n\n\
             /* Where the monitor is between two calls. */\ntypedef struct {name} {{\n    uint32_t state;\n}} {name};\n\n\
             /* Before the first call. To be called before anything else. */\nvoid {name}_reset({name} *monitor);\n\n\
             /* All skills of a mask are called at once. */\nint {name}_call({name} *monitor, uint64_t skills);\n\n\
             /* One skill is called. */\nint {name}_call_one({name} *monitor, unsigned skill);\n\n\
             /* Skills are called one after the other. The result says how many were allowed before the first that was refused; call that one by\n\
             \x20* itself to learn why. */\nsize_t {name}_run({name} *monitor, const uint8_t *skills, size_t count);\n\n\
             /* What {name}_call would be answered with; nothing changes. */\nint {name}_allows(const {name} *monitor, uint64_t skills);\n\n\
             /* The skills that may be called next, each alone, as a mask. */\nuint64_t {name}_allowed(const {name} *monitor);\n\n\
             /* An answer in words: the rule that refused, with its name. */\nconst char *{name}_text(int answer);\n\n\
             #ifdef __cplusplus\n}}\n#endif\n\n#endif\n"
        );
        out
    }

    /// The answer that refuses for a reason.
    fn answer(&self, why: Why) -> i64 {
        -1 - i64::from(self.layout.code(why) - self.layout.refused)
    }

    fn source(&self) -> String {
        let Self {
            table,
            layout,
            name,
            ..
        } = self;
        let mut out = self.about(&format!(" *\n *     cc -std=c99 -O2 -c {name}.c\n"));
        let kind = match layout.code(Why::Unknown) {
            0..=0xff => "uint8_t",
            0x100..=0xffff => "uint16_t",
            _ => "uint32_t",
        };
        let all = match table.skills.len() {
            0 => 0,
            count => u64::MAX >> (64 - count),
        };
        let _ = write!(
            out,
            "#include \"{name}.h\"\n\n\
             /* A state is where its row of {} begins. What is no state says why a call is refused. */\n\
             #define ROW {}u\n#define REFUSED {}u\n#define TOGETHER {}u\n#define UNKNOWN {}u\n\n\
             /* A bit for each skill. */\n#define ALL 0x{all:x}ULL\n\n",
            layout.stride,
            layout.stride,
            layout.refused,
            layout.code(Why::Together),
            layout.code(Why::Unknown),
        );
        let skills: Vec<String> = table.skills.iter().map(|s| comment(s)).collect();
        let about = format!("/* After a single skill: {}. */", skills.join(", "));
        let _ = writeln!(
            out,
            "{}\nstatic const {kind} single[] = {{\n{}}};\n",
            wrap(&about, " * "),
            rows(&layout.single, layout.stride)
        );
        out.push_str(
            "/* The answers in words. */\nstatic const char *const texts[] = {\n    \"allowed\",\n",
        );
        let rules = (0..table.rules.len()).map(Why::Rule);
        for why in rules.chain([Why::Recall, Why::Together]) {
            let _ = writeln!(out, "    {},", string(&why.text(&table.rules)));
        }
        let _ = writeln!(
            out,
            "    {}\n}};\n",
            string(&Why::Unknown.text(&table.rules))
        );
        out.push_str(&self.sets(kind));
        let _ = write!(
            out,
            "/* A state as an answer. */\nstatic int answer(uint32_t to)\n{{\n    return to < REFUSED ? 0 : -1 - (int)(to - REFUSED);\n}}\n\n\
             void {name}_reset({name} *monitor)\n{{\n    monitor->state = {}u;\n}}\n\n",
            layout.start
        );
        let taken = "    if (to < REFUSED) {\n        monitor->state = to;\n    }\n    return answer(to);\n";
        let _ = write!(
            out,
            "int {name}_call({name} *monitor, uint64_t skills)\n{{\n    uint32_t to = after(monitor->state, skills);\n{taken}}}\n\n\
             int {name}_call_one({name} *monitor, unsigned skill)\n{{\n    uint32_t to = skill < ROW ? single[monitor->state + skill] : UNKNOWN;\n{taken}}}\n\n\
             size_t {name}_run({name} *monitor, const uint8_t *skills, size_t count)\n{{\n    uint32_t state = monitor->state;\n    size_t at;\n\
             \x20   for (at = 0; at < count; at++) {{\n        uint32_t to = skills[at] < ROW ? single[state + skills[at]] : UNKNOWN;\n\
             \x20       if (to >= REFUSED) {{\n            break;\n        }}\n        state = to;\n    }}\n    monitor->state = state;\n    return at;\n}}\n\n\
             int {name}_allows(const {name} *monitor, uint64_t skills)\n{{\n    return answer(after(monitor->state, skills));\n}}\n\n\
             uint64_t {name}_allowed(const {name} *monitor)\n{{\n    uint64_t skills = 0;\n    unsigned skill;\n\
             \x20   for (skill = 0; skill < ROW; skill++) {{\n        if (single[monitor->state + skill] < REFUSED) {{\n            skills |= {name}_MASK(skill);\n        }}\n    }}\n    return skills;\n}}\n\n\
             const char *{name}_text(int answer)\n{{\n    const int last = (int)(sizeof texts / sizeof *texts) - 1;\n    return texts[answer > 0 || answer < -last ? last : -answer];\n}}\n"
        );
        out
    }

    /// What a mask leads to, and the tables for sets of several skills where there are any.
    fn sets(&self, kind: &str) -> String {
        let layout = &self.layout;
        let mut out = String::new();
        let several = if layout.sets.is_empty() {
            "    return TOGETHER;\n".to_owned()
        } else {
            out.push_str("/* The sets of skills that may be called at once, in ascending order. */\nstatic const uint64_t sets[] = {\n");
            for set in &layout.sets {
                let all = self.table.skills.iter().enumerate();
                let named = all.filter(|(skill, _)| set >> skill & 1 == 1);
                let named: Vec<String> = named.map(|(_, skill)| comment(skill)).collect();
                let about = wrap(&format!("/* {} */", named.join(" & ")), "     * ");
                let _ = writeln!(out, "    0x{set:x}ULL, {about}");
            }
            let count = layout.sets.len();
            let _ = write!(
                out,
                "}};\n#define SETS {count}u\n\n/* After each of them, a row a state. */\nstatic const {kind} at_once[] = {{\n{}}};\n\n",
                rows(&layout.at_once, count)
            );
            "    while (first < end) {\n        size_t middle = first + (end - first) / 2;\n        if (sets[middle] < skills) {\n            first = middle + 1;\n        } else {\n            end = middle;\n        }\n    }\n\
             \x20   if (first == SETS || sets[first] != skills) {\n        return TOGETHER;\n    }\n    return at_once[state / ROW * SETS + first];\n"
                .to_owned()
        };
        let bounds = if layout.sets.is_empty() {
            ""
        } else {
            "    size_t first = 0, end = SETS;\n"
        };
        let _ = write!(
            out,
            "/* What a state becomes when these skills are called at once. */\nstatic uint32_t after(uint32_t state, uint64_t skills)\n{{\n{bounds}\
             \x20   if (skills == 0) {{\n        return state;\n    }}\n    if ((skills & ~ALL) != 0) {{\n        return UNKNOWN;\n    }}\n\
             \x20   if ((skills & (skills - 1)) == 0) {{\n        unsigned skill = 0;\n        while ((skills >> skill & 1) == 0) {{\n            skill++;\n        }}\n        return single[state + skill];\n    }}\n{several}}}\n\n"
        );
        out
    }
}

/// What of a name can stand behind another.
fn identifier(name: &str) -> String {
    crate::emit::text::identifier(name)
}

/// Numbers, a row of so many to a line.
fn rows(numbers: &[u32], width: usize) -> String {
    numbers.chunks(width).fold(String::new(), |mut out, row| {
        let row: Vec<String> = row.iter().map(u32::to_string).collect();
        let _ = writeln!(out, "    {},", wrap(&row.join(", "), "    "));
        out
    })
}
