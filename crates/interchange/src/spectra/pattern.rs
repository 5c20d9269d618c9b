//! Patterns: `gar respondsTo(a, b);` with
//! `pattern respondsTo(p, q) { var boolean ...; ... GF ...; }`.
//!
//! Each use of a pattern has its own copy of the pattern's variables, as internal variables of the
//! system. As in Spectra, initial and transition formulas of the pattern are guarantees, even if
//! the pattern is assumed; only its `GF` formulas are assumed or guaranteed. A published pattern
//! is lowered to an automaton instead.

use super::reader::{Binding, Reader};
use super::scope::Symbol;
use super::syntax::{Name, Node, Pattern, TemporalForm};
use super::value::Value;
use linewright_core::gr1::Owner;
use linewright_core::source::Span;

impl Reader {
    /// Whether a name refers to a pattern.
    pub fn is_pattern(&self, name: &Name) -> bool {
        let found = self.symbol(&name.text, name.span);
        matches!(found, Some((Symbol::Pattern(_) | Symbol::Published(_), _)))
    }

    pub fn pattern(
        &mut self,
        side: Owner,
        name: &Name,
        arguments: &[Node],
        span: Span,
    ) -> Option<()> {
        let (symbol, _) = self.symbol(&name.text, name.span).cloned()?;
        let wanted = match &symbol {
            Symbol::Pattern(pattern) => pattern.parameters.len(),
            Symbol::Published(published) => published.parameters.len(),
            _ => return None,
        };
        self.check_arity(&name.text, wanted, arguments.len(), span)?;
        let values: Vec<Option<Value>> = match &symbol {
            Symbol::Published(_) => arguments.iter().map(|a| self.truth(a)).collect(),
            _ => arguments.iter().map(|a| self.value(a)).collect(),
        };
        let values: Option<Vec<Value>> = values.into_iter().collect();
        let values = values?;
        match &symbol {
            Symbol::Published(published) => {
                let Some(automaton) = published.automaton() else {
                    self.too_many_states(span);
                    return None;
                };
                self.add_automaton(&automaton, published.name, &values, side, span)
            }
            Symbol::Pattern(pattern) => self.user_pattern(side, pattern, values, span),
            _ => None,
        }
    }

    fn user_pattern(
        &mut self,
        side: Owner,
        pattern: &Pattern,
        values: Vec<Value>,
        span: Span,
    ) -> Option<()> {
        let use_name = self.fresh(&pattern.name.text);
        let mut frame: Vec<(String, Binding)> = pattern
            .parameters
            .iter()
            .map(|p| p.text.clone())
            .zip(values.into_iter().map(Binding::Value))
            .collect();
        let before = self.counts();
        let mut own = Vec::new();
        for variable in &pattern.variables {
            let domain = self.domain(&variable.of)?;
            let name = format!("{use_name}.{}", variable.name.text);
            let cells = self.variables(&name, Owner::System, true, domain, span)?;
            own.extend(cells.ids());
            frame.push((variable.name.text.clone(), Binding::Cells(cells)));
        }
        let done = self.expanded(&pattern.name, span, |reader| {
            if let Some(last) = reader.frames.last_mut() {
                *last = frame;
            }
            for clause in &pattern.clauses {
                let side = match clause.when {
                    TemporalForm::Repeatedly => side,
                    _ => Owner::System,
                };
                if let Some(value) = reader.truth(&clause.node) {
                    reader.add(side, clause.when, value);
                }
            }
            Some(())
        });
        self.record_group(own, before);
        done
    }
}
