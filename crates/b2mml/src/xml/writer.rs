//! Writes elements in the order in which they are given.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, BytesText, Event};

/// An XML document under construction in memory.
pub(crate) struct XmlWriter(Writer<Vec<u8>>);

impl XmlWriter {
    /// Returns the document with a root in a default namespace, with what `inside` writes.
    pub(crate) fn document(root: &str, namespace: &str, inside: impl FnOnce(&mut Self)) -> String {
        let mut writer = Self(Writer::new_with_indent(Vec::new(), b' ', 1));
        writer.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        writer.element_with(root, &[("xmlns", namespace)], inside);
        let mut bytes = writer.0.into_inner();
        bytes.push(b'\n');
        String::from_utf8(bytes).expect("only texts were written")
    }

    fn event(&mut self, event: Event<'_>) {
        (self.0.write_event(event)).expect("writing to memory does not fail");
    }

    /// Writes an element with the content that `inside` writes.
    pub(crate) fn element(&mut self, name: &str, inside: impl FnOnce(&mut Self)) {
        self.element_with(name, &[], inside);
    }

    fn element_with(
        &mut self,
        name: &str,
        attributes: &[(&str, &str)],
        inside: impl FnOnce(&mut Self),
    ) {
        let start = BytesStart::new(name).with_attributes(attributes.iter().copied());
        self.event(Event::Start(start));
        inside(self);
        self.event(Event::End(BytesEnd::new(name)));
    }

    /// Writes an element with a text.
    pub(crate) fn text(&mut self, name: &str, text: &str) {
        self.text_with(name, &[], text);
    }

    /// Writes an element with attributes and a text.
    pub(crate) fn text_with(&mut self, name: &str, attributes: &[(&str, &str)], text: &str) {
        self.element_with(name, attributes, |w| {
            w.event(Event::Text(BytesText::new(text)));
        });
    }
}
