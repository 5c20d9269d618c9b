//! The tree, and its construction from the events of `quick-xml`.

use super::INSTANCE;
use super::check::{self, Broken, is_blank};
use crate::finding::{Collector, Rule, quoted};
use quick_xml::events::{BytesStart, Event};
use quick_xml::name::{Namespace, PrefixDeclaration, QName, ResolveResult};
use quick_xml::reader::NsReader;
use std::borrow::Cow;

/// Maximum depth of elements. Documents that are written have at most 6; the schema allows any.
const MAX_DEPTH: usize = 100;
/// Maximum number of elements. Each takes some 150 bytes.
const MAX_ELEMENTS: usize = 4_000_000;

/// Number of an element in its tree.
pub(crate) type Element = usize;

/// A document. Its elements are numbered in the order of their start tags.
#[derive(Default)]
pub(crate) struct Tree<'t> {
    elements: Vec<Node<'t>>,
    /// Namespace of the root; empty if it has none.
    namespace: String,
}

struct Node<'t> {
    /// Name without its prefix.
    name: &'t str,
    /// Whether it is in the namespace that was asked for.
    is_known: bool,
    /// Byte offset of its start tag.
    at: usize,
    attributes: Vec<Attribute<'t>>,
    /// All text in it, without that of its children.
    text: Cow<'t, str>,
    /// Byte offset of the first text in it that is not white space.
    text_at: Option<usize>,
    first_child: Option<Element>,
    next_sibling: Option<Element>,
}

/// An attribute, without those that declare namespaces.
pub(crate) struct Attribute<'t> {
    /// Byte offset.
    pub at: usize,
    /// Where its name comes from.
    pub origin: Origin,
    /// Name without its prefix.
    pub name: &'t str,
    /// Value.
    pub value: String,
}

/// Namespace of an attribute.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Origin {
    /// None.
    Own,
    /// That of XML Schema instances.
    Instance,
    /// Any other.
    Other,
}

impl<'t> Tree<'t> {
    /// Returns the name of an element, without a prefix.
    pub(crate) fn name(&self, element: Element) -> &'t str {
        self.elements[element].name
    }

    /// Returns the namespace of the root; empty if it has none.
    pub(crate) fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Returns whether an element is in the namespace that was asked for.
    pub(crate) fn is_known(&self, element: Element) -> bool {
        self.elements[element].is_known
    }

    /// Returns the byte offset of an element.
    pub(crate) fn at(&self, element: Element) -> usize {
        self.elements[element].at
    }

    /// Returns the attributes of an element.
    pub(crate) fn attributes(&self, element: Element) -> &[Attribute<'t>] {
        &self.elements[element].attributes
    }

    /// Returns the text of an element, without that of its children.
    pub(crate) fn text(&self, element: Element) -> &str {
        &self.elements[element].text
    }

    /// Returns the place of the first text of an element that is not white space.
    pub(crate) fn text_at(&self, element: Element) -> Option<usize> {
        self.elements[element].text_at
    }

    /// Returns the children of an element.
    pub(crate) fn children(&self, element: Element) -> impl Iterator<Item = Element> {
        let first = self.elements[element].first_child;
        std::iter::successors(first, |e| self.elements[*e].next_sibling)
    }

    /// Returns the number of elements.
    pub(crate) fn len(&self) -> usize {
        self.elements.len()
    }
}

/// An element that has not ended.
struct Open {
    element: Element,
    last_child: Option<Element>,
}

/// Reads a text as a tree, whose root is element 0. Names in `namespace` are the known ones.
///
/// Returns nothing if the text is not well-formed or too large; the first reason is added to the
/// findings. Takes time and memory proportional to the text.
pub(crate) fn parse<'t>(
    text: &'t str,
    namespace: &str,
    findings: &mut Collector,
) -> Option<Tree<'t>> {
    let mut builder = Builder {
        text,
        namespace,
        tree: Tree::default(),
        open: Vec::new(),
    };
    match builder.read() {
        Ok(()) => Some(builder.tree),
        Err((at, rule, message)) => {
            findings.add(at, rule, message);
            None
        }
    }
}

type Refusal = (usize, Rule, String);

/// Returns a function that makes a refusal of a broken rule of a text that begins at an offset.
fn within(offset: usize) -> impl Fn(Broken) -> Refusal {
    move |(at, message)| (offset + at, Rule::Syntax, message)
}

struct Builder<'t, 'n> {
    text: &'t str,
    namespace: &'n str,
    tree: Tree<'t>,
    open: Vec<Open>,
}

impl<'t> Builder<'t, '_> {
    fn read(&mut self) -> Result<(), Refusal> {
        let text = self.text;
        check::characters(text).map_err(within(0))?;
        let mut reader = NsReader::from_str(text);
        reader.config_mut().check_comments = true;
        loop {
            let at = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| {
                let place = (reader.error_position() as usize).max(at.min(text.len()));
                (place, Rule::Syntax, error.to_string())
            })?;
            let end = reader.buffer_position() as usize;
            let raw = text.get(at..end).unwrap_or_default();
            let wrong = |message: &str| (at, Rule::Syntax, message.to_owned());
            match event {
                Event::Start(start) => self.start(&reader, &start, at)?,
                Event::Empty(start) => {
                    self.start(&reader, &start, at)?;
                    self.open.pop();
                }
                Event::End(_) => {
                    self.open.pop();
                }
                Event::Text(_) if is_blank(raw) && !raw.contains('\r') => {
                    self.add_text(at, Cow::Borrowed(raw), false)?;
                }
                Event::Text(_) => {
                    if let Some(brackets) = raw.find("]]>") {
                        let message = "`]]>` is not allowed in a text".to_owned();
                        return Err((at + brackets, Rule::Syntax, message));
                    }
                    let content = if raw.contains('\r') {
                        Cow::Owned(raw.replace("\r\n", "\n").replace('\r', "\n"))
                    } else {
                        Cow::Borrowed(raw)
                    };
                    self.add_text(at, content, false)?;
                }
                Event::CData(data) => {
                    let content = data.xml10_content().into_owned();
                    self.add_text(at, Cow::Owned(content), true)?;
                }
                Event::GeneralRef(name) => {
                    let character = check::reference(&name).map_err(|m| wrong(&m))?;
                    self.add_text(at, Cow::Owned(character.to_string()), true)?;
                }
                Event::Comment(_) => {}
                Event::PI(instruction) => {
                    let target = instruction.target();
                    let content = instruction.content();
                    if !check::is_plain_name(target) || target.eq_ignore_ascii_case("xml") {
                        return Err(wrong("a processing instruction has no proper name"));
                    }
                    if !content.is_empty() && !content.starts_with([' ', '\t', '\r', '\n']) {
                        return Err(wrong("a processing instruction has no proper name"));
                    }
                }
                Event::Decl(_) => {
                    if at > 0 {
                        return Err(wrong("the XML declaration is not at the beginning"));
                    }
                    let inner = raw.strip_prefix("<?xml").and_then(|r| r.strip_suffix("?>"));
                    check::declaration(inner.unwrap_or_default()).map_err(within(5))?;
                }
                Event::DocType(_) => {
                    let message = "a document type declaration is not read";
                    return Err((at, Rule::DocumentType, message.to_owned()));
                }
                Event::Eof => break,
            }
        }
        if let Some(open) = self.open.last() {
            let message = format!("{} does not end", quoted(self.tree.name(open.element)));
            return Err((self.tree.at(open.element), Rule::Syntax, message));
        }
        if self.tree.len() == 0 {
            return Err((text.len(), Rule::Syntax, "there is no element".to_owned()));
        }
        Ok(())
    }

    fn start(
        &mut self,
        reader: &NsReader<&'t [u8]>,
        start: &BytesStart<'_>,
        at: usize,
    ) -> Result<(), Refusal> {
        let wrong = |message: String| (at, Rule::Syntax, message);
        let length = start.name().as_ref().len();
        let full = &self.text[at + 1..at + 1 + length];
        if !check::is_name(full) {
            return Err(wrong(format!("{} is not a name", quoted(full))));
        }
        if self.open.is_empty() && self.tree.len() > 0 {
            return Err(wrong("there is a second root".to_owned()));
        }
        if self.open.len() == MAX_DEPTH {
            let message = format!("elements are nested deeper than {MAX_DEPTH}");
            return Err((at, Rule::Size, message));
        }
        if self.tree.len() == MAX_ELEMENTS {
            let message = format!("there are more than {MAX_ELEMENTS} elements");
            return Err((at, Rule::Size, message));
        }
        let is_known = match reader.resolver().resolve_element(QName(full)).0 {
            ResolveResult::Bound(Namespace(bound)) => {
                if self.tree.len() == 0 {
                    bound.clone_into(&mut self.tree.namespace);
                }
                bound == self.namespace
            }
            ResolveResult::Unbound => self.namespace.is_empty(),
            ResolveResult::Unknown(prefix) => {
                return Err(wrong(format!("prefix {} is not declared", quoted(&prefix))));
            }
        };
        let attributes = self.attributes(reader, start.attributes_raw(), at + 1 + length)?;
        let element = self.tree.len();
        self.tree.elements.push(Node {
            name: full.rsplit(':').next().unwrap_or(full),
            is_known,
            at,
            attributes,
            text: Cow::Borrowed(""),
            text_at: None,
            first_child: None,
            next_sibling: None,
        });
        if let Some(parent) = self.open.last_mut() {
            match parent.last_child.replace(element) {
                Some(last) => self.tree.elements[last].next_sibling = Some(element),
                None => self.tree.elements[parent.element].first_child = Some(element),
            }
        }
        self.open.push(Open {
            element,
            last_child: None,
        });
        Ok(())
    }

    /// Reads attributes from their text, which begins at `offset`.
    fn attributes(
        &self,
        reader: &NsReader<&'t [u8]>,
        written: &str,
        offset: usize,
    ) -> Result<Vec<Attribute<'t>>, Refusal> {
        if written.is_empty() {
            return Ok(Vec::new());
        }
        let raw = &self.text[offset..offset + written.len()];
        let raw = check::attributes(raw).map_err(within(offset))?;
        let mut attributes: Vec<Attribute<'t>> = Vec::new();
        let mut others: Vec<(String, &str)> = Vec::new();
        for attribute in raw {
            let at = offset + attribute.at;
            let value = check::attribute_value(attribute.value)
                .map_err(within(offset + attribute.value_at))?;
            let name = QName(attribute.name);
            match name.as_namespace_binding() {
                Some(PrefixDeclaration::Named(_)) if value.is_empty() => {
                    let message = "a prefix is declared without a namespace".to_owned();
                    return Err((at, Rule::Syntax, message));
                }
                Some(_) => continue,
                None => {}
            }
            let origin = match reader.resolver().resolve_attribute(name).0 {
                ResolveResult::Unbound => Origin::Own,
                ResolveResult::Bound(Namespace(bound)) => {
                    let local = name.local_name().into_inner();
                    let bound = (bound.to_owned(), local);
                    if others.contains(&bound) {
                        let message = format!("attribute {} occurs twice", quoted(local));
                        return Err((at, Rule::Syntax, message));
                    }
                    let is_instance = bound.0 == INSTANCE;
                    others.push(bound);
                    if is_instance {
                        Origin::Instance
                    } else {
                        Origin::Other
                    }
                }
                ResolveResult::Unknown(prefix) => {
                    let message = format!("prefix {} is not declared", quoted(&prefix));
                    return Err((at, Rule::Syntax, message));
                }
            };
            attributes.push(Attribute {
                at,
                origin,
                name: attribute.name.rsplit(':').next().unwrap_or_default(),
                value,
            });
        }
        Ok(attributes)
    }

    /// Adds text to the open element. Text in a section or from a reference is never mere layout.
    fn add_text(
        &mut self,
        at: usize,
        content: Cow<'t, str>,
        is_deliberate: bool,
    ) -> Result<(), Refusal> {
        let visible = is_deliberate || !is_blank(&content);
        let Some(open) = self.open.last() else {
            if visible {
                let message = "there is text outside of the root".to_owned();
                return Err((at, Rule::Syntax, message));
            }
            return Ok(());
        };
        let node = &mut self.tree.elements[open.element];
        if visible && node.text_at.is_none() {
            node.text_at = Some(at);
        }
        if node.first_child.is_some() {
            // No element of the schema has text and children, so only its place matters.
            return Ok(());
        }
        if node.text.is_empty() {
            node.text = content;
        } else {
            node.text.to_mut().push_str(&content);
        }
        Ok(())
    }
}
