//! Arrays: elements with constant or variable indices, and functions of all elements.
//!
//! `a[i]` becomes a choice between the elements that `i` can select. As in Spectra, an index that
//! can be outside the array is an error.

use super::reader::{Binding, Reader};
use super::scope::{Cells, Symbol};
use super::syntax::{Define, Elements, Name, Node};
use super::value::{Kind, Value};
use linewright_core::diagnostics::codes;
use linewright_core::gr1::interval::interval;
use linewright_core::gr1::{BinaryOp, Expr, VarId};
use linewright_core::source::Span;
use std::rc::Rc;

impl Reader {
    /// The value of a variable or of an array element such as `a[1][i]`.
    pub fn element(
        &mut self,
        cells: &Cells,
        name: &str,
        indices: &[Node],
        span: Span,
    ) -> Option<Value> {
        if cells.sizes.is_empty() {
            self.no_indices(name, indices, span)?;
            return Some(self.mention(cells.first, span));
        }
        self.check_dimensions(name, &cells.sizes, indices, span)?;
        let indices = self.indices(&cells.sizes, indices)?;
        self.choose(&cells.sizes, &indices, 0, &mut |reader, place| {
            Some(reader.mention(VarId(cells.first.0 + place as u32), span))
        })
    }

    /// The value of an element of an array define.
    pub fn defined_element(
        &mut self,
        define: &Rc<Define>,
        indices: &[Node],
        span: Span,
    ) -> Option<Value> {
        let name = &define.name;
        let sizes: Option<Vec<i64>> = define.sizes.iter().map(|n| self.number(n)).collect();
        let sizes = sizes?;
        let elements = self.elements(define, &sizes)?;
        self.check_dimensions(&name.text, &sizes, indices, span)?;
        let indices = self.indices(&sizes, indices)?;
        self.choose(&sizes, &indices, 0, &mut |reader, place| {
            let node = elements.get(place)?;
            reader.expanded(name, span, |reader| reader.value(node))
        })
    }

    /// The elements of an array define in row-major order. If their number is wrong, reports this
    /// and returns `None`.
    fn elements<'d>(&mut self, define: &'d Define, sizes: &[i64]) -> Option<Vec<&'d Node>> {
        let mut level = vec![&define.value];
        for size in sizes {
            let mut next = Vec::new();
            for elements in level {
                match elements {
                    Elements::Many(found, _) if found.len() as i64 == *size => next.extend(found),
                    Elements::Many(found, span) => {
                        let count = found.len();
                        self.report_count(define, *span, *size, count);
                        return None;
                    }
                    Elements::One(node) => {
                        self.report_count(define, node.span, *size, 1);
                        return None;
                    }
                }
            }
            level = next;
        }
        let found: Option<Vec<&Node>> = level
            .into_iter()
            .map(|e| match e {
                Elements::One(node) => Some(node),
                Elements::Many(..) => None,
            })
            .collect();
        if found.is_none() {
            self.report_count(define, define.name.span, 1, 2);
        }
        found
    }

    fn report_count(&mut self, define: &Define, span: Span, wanted: i64, found: usize) {
        self.error(
            codes::INDEX_RANGE,
            span,
            format!(
                "`{}` needs {wanted} elements here, but has {found}",
                define.name.text
            ),
            "write as many elements as the brackets after the name state, in braces for each dimension",
        );
    }

    fn check_dimensions(
        &mut self,
        name: &str,
        sizes: &[i64],
        indices: &[Node],
        span: Span,
    ) -> Option<()> {
        if sizes.len() == indices.len() {
            return Some(());
        }
        self.error(
            codes::TYPE_MISMATCH,
            span,
            format!(
                "`{name}` is an array of {} dimensions, but has {} indices here",
                sizes.len(),
                indices.len()
            ),
            "write one index for each dimension, or apply `.all`, `.any`, `.sum`, `.prod`, `.min` or `.max` to the whole array",
        );
        None
    }

    /// The values of the indices, each with its smallest and largest value. If one can be outside
    /// the array, reports this and returns `None`.
    fn indices(&mut self, sizes: &[i64], nodes: &[Node]) -> Option<Vec<(Value, i64, i64)>> {
        let mut found = Vec::new();
        for (node, size) in nodes.iter().zip(sizes) {
            let value = self.value(node)?;
            self.expect_kind(&value, &Kind::Int, node.span)?;
            let range = interval(&value.expr.simplify(), &|v| self.interval(v)).ok()?;
            if range.low < 0 || range.high >= *size {
                let message = if range.low == range.high {
                    format!("the index {} is outside the array", range.low)
                } else {
                    format!(
                        "this index can be {} to {}, but the array ends at {}",
                        range.low,
                        range.high,
                        size - 1
                    )
                };
                self.error(
                    codes::INDEX_RANGE,
                    node.span,
                    message,
                    format!("use an index from 0 to {}", size - 1),
                );
                return None;
            }
            found.push((value, range.low, range.high));
        }
        Some(found)
    }

    /// The element that the indices select, as a chain of conditionals.
    ///
    /// `place` is the row-major position that the indices of the earlier dimensions give; `element`
    /// returns the element at a position.
    fn choose(
        &mut self,
        sizes: &[i64],
        indices: &[(Value, i64, i64)],
        place: usize,
        element: &mut dyn FnMut(&mut Self, usize) -> Option<Value>,
    ) -> Option<Value> {
        let ([size, sizes @ ..], [(index, low, high), rest @ ..]) = (sizes, indices) else {
            return element(self, place);
        };
        let place = place * *size as usize;
        let mut found = self.choose(sizes, rest, place + *high as usize, element)?;
        for number in (*low..*high).rev() {
            let other = self.choose(sizes, rest, place + number as usize, element)?;
            let is = Value::binary(BinaryOp::Eq, index.clone(), Value::int(number));
            found = Value::choose(is, other, found);
            found = self.check_size(found, self.origin.span)?;
        }
        Some(found)
    }

    /// The value of `a.all`, `a.any`, `a.sum`, `a.prod`, `a.min` or `a.max`; a variable that is not
    /// an array counts as one element.
    pub fn function(&mut self, name: &Name, indices: &[Node], function: &Name) -> Option<Value> {
        let cells = match (self.bound(&name.text), self.symbol(&name.text, name.span)) {
            (Some(Binding::Cells(cells)), _) | (None, Some((Symbol::Variable(cells), _))) => {
                cells.clone()
            }
            _ => {
                self.unknown("array", &name.text, name.span);
                return None;
            }
        };
        self.no_indices(&name.text, indices, name.span)?;
        let count: i64 = cells.sizes.iter().product();
        let mut values = Vec::new();
        for place in 0..count as u32 {
            values.push(self.mention(VarId(cells.first.0 + place), name.span));
        }
        let (kind, op) = match function.text.as_str() {
            "all" => (Kind::Bool, BinaryOp::And),
            "any" => (Kind::Bool, BinaryOp::Or),
            "sum" => (Kind::Int, BinaryOp::Add),
            "prod" => (Kind::Int, BinaryOp::Mul),
            "min" => (Kind::Int, BinaryOp::Min),
            _ => (Kind::Int, BinaryOp::Max),
        };
        for value in &values {
            self.expect_kind(value, &kind, name.span)?;
        }
        Some(Value::chain(op, values))
    }

    /// The binding of an argument that is a whole array; `None` for other arguments.
    pub fn whole_array(&mut self, node: &Node) -> Option<Binding> {
        let super::syntax::Shape::Name(name, indices) = &node.shape else {
            return None;
        };
        if !indices.is_empty() {
            return None;
        }
        match (self.bound(name), self.symbol(name, node.span)) {
            (Some(binding @ (Binding::Cells(_) | Binding::Elements(_))), _) => {
                Some(binding.clone())
            }
            (None, Some((Symbol::Variable(cells), _))) if !cells.sizes.is_empty() => {
                Some(Binding::Cells(cells.clone()))
            }
            (None, Some((Symbol::Define(define), _))) if !define.sizes.is_empty() => {
                Some(Binding::Elements(Rc::clone(define)))
            }
            _ => None,
        }
    }
}

/// The constant `value`, with the type of `domain`.
pub(super) fn constant(domain: &linewright_core::gr1::Domain, value: i64) -> Value {
    Value::leaf(Expr::Const(value), super::types::kind_of(domain))
}
