//! Mutation testing within one build: copies of source files in which every condition, comparison,
//! quantifier, boundary and statement can be made wrong at run time ("mutant schemata"; Untch,
//! Offutt, Harrold 1993).
//!
//! ```ignore
//! mutation::mutants! { "crates/solver/src/mealy/certify.rs",
//! "crates/solver/src/mealy/verify/mod.rs" }
//! ```
//!
//! makes a module `certify` and a module `verify` of these files, whose paths are relative to the
//! package's folder, with the files named by their `mod` items, and a list `MUTANTS` that describes
//! each mutant. The files themselves are unchanged, and none of this is in any build but the
//! test's. `crate::` in them becomes `linewright::`. At each place the copy calls
//! `crate::switch::at(first, count)`, which returns `i` if mutant `first + i - 1` is active, and 0
//! otherwise.
//!
//! | operator | changes |
//! |---|---|
//! | comparison | `<` and `<=`, `>` and `>=` exchanged; each reversed; `==` and `!=` exchanged |
//! | logic | `&&` and `||` exchanged, `!` removed |
//! | condition | of an `if`, a guard, a predicate argument: always, never |
//! | quantifier | `any` and `all`, `is_some_and` and `is_none_or` exchanged |
//! | loop | over nothing, over all but the first, over the first only; a `chain` without its second part |
//! | arithmetic | `+` and `-`, `*` and `/`, `<<` and `>>`, `&` and `|` exchanged |
//! | constant | truth values, `Time::Now` and `Time::Next`, the two owners, numbers by one |
//! | statement | a call, an assignment, a `?` removed |
//! | set | operations of the kernel exchanged (`and`, `or`, `and_not`, `xor`, `iff`), `prime` removed |
//! | arm | if two arms of a `match` each give a name, the other name |
//!
//! Not mutated: constants outside of functions, display code (`Display`, `Debug`), and code that
//! affects only duration and never results: calls that check the clock or give a kernel an
//! opportunity ([`SPEED`]), with conditions that guard nothing else, and comparisons with constants
//! that choose a way by size ([`SIZES`]).

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote};
use std::path::{Path, PathBuf};
use syn::parse::{Parse, ParseStream};
use syn::punctuated::Punctuated;
use syn::visit_mut::{self, VisitMut};
use syn::{BinOp, Expr, ExprLit, Ident, Item, Lit, LitStr, Stmt, Token, UnOp, parse_quote};

/// Methods that affect only duration, never results.
const SPEED: [&str; 4] = ["check_time", "safe_point", "set_reordering", "reserve"];

/// Suffix of constants that choose between two correct ways by size.
const SIZES: &str = "_NODES";

/// Methods whose argument is a predicate.
const PREDICATES: [&str; 11] = [
    "all",
    "any",
    "filter",
    "find",
    "position",
    "retain",
    "is_some_and",
    "is_none_or",
    "take_while",
    "skip_while",
    "partition",
];

/// Methods that are exchanged for each other.
const METHODS: [(&str, &str); 14] = [
    ("any", "all"),
    ("all", "any"),
    ("is_some_and", "is_none_or"),
    ("is_none_or", "is_some_and"),
    ("is_some", "is_none"),
    ("is_none", "is_some"),
    ("is_err", "is_ok"),
    ("is_ok", "is_err"),
    ("min", "max"),
    ("max", "min"),
    ("xor", "iff"),
    ("iff", "xor"),
    ("and_not", "and"),
    ("or", "and"),
];

struct Files(Vec<LitStr>);

impl Parse for Files {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let files = Punctuated::<LitStr, Token![,]>::parse_terminated(input)?;
        Ok(Self(files.into_iter().collect()))
    }
}

/// Copies of files with a switch at every place that can be made wrong.
#[proc_macro]
pub fn mutants(input: proc_macro::TokenStream) -> proc_macro::TokenStream {
    let Files(files) = syn::parse_macro_input!(input as Files);
    let mut switcher = Switcher::default();
    let mut modules = TokenStream::new();
    for file in files {
        match module(&mut switcher, &file) {
            Ok(module) => modules.extend(module),
            Err(error) => modules.extend(syn::Error::new(file.span(), error).to_compile_error()),
        }
    }
    let mutants = switcher.made.iter().map(|m| {
        let (file, function, operator) = (&m.file, &m.function, m.operator);
        let (right, wrong) = (&m.right, &m.wrong);
        quote!(crate::switch::Mutant { file: #file, function: #function, operator: #operator, right: #right, wrong: #wrong })
    });
    quote! {
        #modules
        /// Description of each mutant, by number.
        pub const MUTANTS: &[crate::switch::Mutant] = &[#(#mutants),*];
    }
    .into()
}

/// The module made of a file.
fn module(switcher: &mut Switcher, file: &LitStr) -> Result<TokenStream, String> {
    let root = std::env::var("CARGO_MANIFEST_DIR").map_err(|e| e.to_string())?;
    let path = file.value();
    let stem = path.trim_end_matches(".rs").trim_end_matches("/mod");
    let name = Ident::new(stem.rsplit('/').next().unwrap_or(stem), Span::call_site());
    let items = items(switcher, Path::new(&root), Path::new(&path))?;
    Ok(quote! {
        #[allow(warnings, clippy::all, clippy::pedantic, reason = "a copy; the file itself is looked at")]
        pub mod #name { #items }
    })
}

/// The items of a file, including those of its modules.
fn items(switcher: &mut Switcher, root: &Path, path: &Path) -> Result<TokenStream, String> {
    let whole = root.join(path);
    let said = |error: String| format!("{}: {error}", path.display());
    let text = std::fs::read_to_string(&whole).map_err(|e| said(e.to_string()))?;
    let file = syn::parse_file(&text).map_err(|e| said(e.to_string()))?;
    let place = whole.display().to_string();
    // Tells the compiler when to make the copy anew.
    let mut result = quote!(
        const _: &str = include_str!(#place);
    );
    for mut item in file.items {
        if attributes(&item).iter().any(|a| a.path().is_ident("cfg")) {
            continue;
        }
        if let Item::Mod(module) = &item
            && module.content.is_none()
        {
            let name = &module.ident;
            let inner = items(switcher, root, &file_of(path, &name.to_string()))?;
            result.extend(quote!(pub mod #name { #inner }));
            continue;
        }
        switcher.file = path.display().to_string();
        switcher.visit_item_mut(&mut item);
        item.to_tokens(&mut result);
    }
    Ok(result)
}

fn attributes(item: &Item) -> &[syn::Attribute] {
    match item {
        Item::Mod(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        _ => &[],
    }
}

/// Path of a module's file.
fn file_of(path: &Path, name: &str) -> PathBuf {
    let folder = path.parent().unwrap_or(path);
    if path.file_stem().is_some_and(|s| s == "mod") {
        return folder.join(format!("{name}.rs"));
    }
    folder
        .join(path.file_stem().unwrap_or_default())
        .join(format!("{name}.rs"))
}

struct Made {
    file: String,
    function: String,
    operator: &'static str,
    right: String,
    wrong: String,
}

#[derive(Default)]
struct Switcher {
    made: Vec<Made>,
    file: String,
    functions: Vec<String>,
}

/// An expression on one line.
fn shown(tokens: &impl ToTokens) -> String {
    let text = tokens.to_token_stream().to_string();
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.chars().count() > 110 {
        let begin: String = line.chars().take(107).collect();
        return format!("{begin}...");
    }
    line
}

impl Switcher {
    /// Registers the mutants of one place; returns the query for the active one.
    fn note(
        &mut self,
        operator: &'static str,
        right: &impl ToTokens,
        wrong: &[String],
    ) -> TokenStream {
        let first = self.made.len() as u32;
        let count = wrong.len() as u32;
        for wrong in wrong {
            self.made.push(Made {
                file: self.file.clone(),
                function: self.functions.last().cloned().unwrap_or_default(),
                operator,
                right: shown(right),
                wrong: wrong.clone(),
            });
        }
        quote!(crate::switch::at(#first, #count))
    }

    /// Adds alternatives to an expression whose parts have been processed.
    fn choose(&mut self, operator: &'static str, place: &mut Expr, right: &Expr, wrong: Vec<Expr>) {
        let shown = wrong.iter().map(shown).collect::<Vec<_>>();
        let question = self.note(operator, right, &shown);
        let arms = wrong.iter().zip(1u32..).map(|(e, i)| quote!(#i => #e,));
        let now = &*place;
        *place = parse_quote!((match #question { #(#arms)* _ => #now }));
    }

    /// A condition: always, never, and the values of its parts.
    fn condition(&mut self, condition: &mut Expr) {
        if !has_let(condition) && by_size(condition) {
            PathChanger.visit_expr_mut(condition);
            return;
        }
        if has_let(condition) {
            if let Expr::Binary(chain) = condition {
                self.condition(&mut chain.left);
                self.condition(&mut chain.right);
            } else {
                visit_mut::visit_expr_mut(self, condition);
            }
            return;
        }
        let right = condition.clone();
        self.visit_expr_mut(condition);
        self.choose(
            "condition",
            condition,
            &right,
            vec![parse_quote!(true), parse_quote!(false)],
        );
    }
}

/// Whether a condition compares with a constant that chooses a way by size.
fn by_size(condition: &Expr) -> bool {
    match condition {
        Expr::Binary(binary) => match &*binary.right {
            Expr::Path(path) => {
                let last = path.path.segments.last();
                last.is_some_and(|s| s.ident.to_string().ends_with(SIZES))
            }
            _ => false,
        },
        _ => false,
    }
}

/// Whether a condition binds names.
fn has_let(condition: &Expr) -> bool {
    match condition {
        Expr::Let(_) => true,
        Expr::Binary(chain) if matches!(chain.op, BinOp::And(_)) => {
            has_let(&chain.left) || has_let(&chain.right)
        }
        _ => false,
    }
}

/// Whether a statement affects no verdict.
fn only_speed(statement: &Stmt) -> bool {
    let Stmt::Expr(expression, _) = statement else {
        return false;
    };
    let call = match expression {
        Expr::Try(inner) => &*inner.expr,
        other => other,
    };
    match call {
        Expr::MethodCall(call) => SPEED.iter().any(|s| call.method == s),
        Expr::If(branch) => {
            branch.else_branch.is_none() && branch.then_branch.stmts.iter().all(only_speed)
        }
        _ => false,
    }
}

/// The name bound by an arm of a `match`.
fn arm_name(arm: &syn::Arm) -> Option<&Ident> {
    match &*arm.body {
        Expr::Path(path) => path.path.get_ident(),
        _ => None,
    }
}

fn comparisons(op: &BinOp) -> Vec<BinOp> {
    match op {
        BinOp::Lt(_) => vec![parse_quote!(<=), parse_quote!(>=)],
        BinOp::Le(_) => vec![parse_quote!(<), parse_quote!(>)],
        BinOp::Gt(_) => vec![parse_quote!(>=), parse_quote!(<=)],
        BinOp::Ge(_) => vec![parse_quote!(>), parse_quote!(<)],
        BinOp::Eq(_) => vec![parse_quote!(!=)],
        BinOp::Ne(_) => vec![parse_quote!(==)],
        _ => Vec::new(),
    }
}

fn arithmetic(op: &BinOp) -> Option<BinOp> {
    Some(match op {
        BinOp::Add(_) => parse_quote!(-),
        BinOp::Sub(_) => parse_quote!(+),
        BinOp::Mul(_) => parse_quote!(/),
        BinOp::Div(_) | BinOp::Rem(_) => parse_quote!(*),
        BinOp::Shl(_) => parse_quote!(>>),
        BinOp::Shr(_) => parse_quote!(<<),
        BinOp::BitAnd(_) => parse_quote!(|),
        BinOp::BitOr(_) => parse_quote!(&),
        _ => return None,
    })
}

impl VisitMut for Switcher {
    fn visit_item_mut(&mut self, item: &mut Item) {
        match item {
            // Small in the copy, so that small artefacts take both ways.
            Item::Const(constant) if constant.ident.to_string().ends_with(SIZES) => {
                if constant.ident != "SMALL_NODES" {
                    *constant.expr = parse_quote!(16);
                }
            }
            Item::Const(_) | Item::Static(_) | Item::Macro(_) => {}
            Item::Impl(block) => {
                let shows = block.trait_.as_ref().is_some_and(|(_, path, _)| {
                    path.segments.last().is_some_and(|s| {
                        s.ident == "Display" || s.ident == "Debug" || s.ident == "Hasher"
                    })
                });
                if shows {
                    PathChanger.visit_item_impl_mut(block);
                } else {
                    for item in &mut block.items {
                        if let syn::ImplItem::Fn(function) = item
                            && block.trait_.is_none()
                        {
                            function.vis = parse_quote!(pub);
                        }
                    }
                    visit_mut::visit_item_impl_mut(self, block);
                }
            }
            _ => visit_mut::visit_item_mut(self, item),
        }
    }

    fn visit_item_struct_mut(&mut self, item: &mut syn::ItemStruct) {
        item.vis = parse_quote!(pub);
        for field in &mut item.fields {
            field.vis = parse_quote!(pub);
        }
        PathChanger.visit_item_struct_mut(item);
    }

    fn visit_item_fn_mut(&mut self, function: &mut syn::ItemFn) {
        self.functions.push(function.sig.ident.to_string());
        visit_mut::visit_item_fn_mut(self, function);
        self.functions.pop();
    }

    fn visit_impl_item_fn_mut(&mut self, function: &mut syn::ImplItemFn) {
        self.functions.push(function.sig.ident.to_string());
        visit_mut::visit_impl_item_fn_mut(self, function);
        self.functions.pop();
    }

    fn visit_path_mut(&mut self, path: &mut syn::Path) {
        PathChanger.visit_path_mut(path);
        visit_mut::visit_path_mut(self, path);
    }

    fn visit_use_tree_mut(&mut self, tree: &mut syn::UseTree) {
        PathChanger.visit_use_tree_mut(tree);
    }

    fn visit_visibility_mut(&mut self, visibility: &mut syn::Visibility) {
        // The tests access inner parts, too.
        *visibility = match visibility {
            syn::Visibility::Restricted(_) => parse_quote!(pub),
            _ => visibility.clone(),
        };
    }

    // Numbers in these are not mutated.
    fn visit_pat_mut(&mut self, pattern: &mut syn::Pat) {
        PathChanger.visit_pat_mut(pattern);
    }

    fn visit_type_mut(&mut self, kind: &mut syn::Type) {
        PathChanger.visit_type_mut(kind);
    }

    fn visit_block_mut(&mut self, block: &mut syn::Block) {
        for statement in &mut block.stmts {
            if only_speed(statement) {
                PathChanger.visit_stmt_mut(statement);
                continue;
            }
            let right = statement.clone();
            self.visit_stmt_mut(statement);
            let Stmt::Expr(expression, Some(_)) = &right else {
                continue;
            };
            let can_go = match expression {
                Expr::MethodCall(_) | Expr::Assign(_) => true,
                Expr::Try(inner) => matches!(&*inner.expr, Expr::MethodCall(_) | Expr::Call(_)),
                Expr::Binary(b) => matches!(
                    b.op,
                    BinOp::AddAssign(_)
                        | BinOp::SubAssign(_)
                        | BinOp::BitOrAssign(_)
                        | BinOp::BitXorAssign(_)
                ),
                _ => false,
            };
            if can_go {
                let question = self.note("statement", expression, &[String::new()]);
                let now = &*statement;
                *statement = parse_quote!(if #question == 0 { #now });
            }
        }
    }

    fn visit_arm_mut(&mut self, arm: &mut syn::Arm) {
        PathChanger.visit_pat_mut(&mut arm.pat);
        if let Some((_, guard)) = &mut arm.guard {
            self.condition(guard);
        }
        self.visit_expr_mut(&mut arm.body);
    }

    fn visit_expr_mut(&mut self, place: &mut Expr) {
        let right = place.clone();
        match place {
            Expr::Binary(_) if has_let(&right) => self.condition(place),
            Expr::Binary(binary) => {
                self.visit_expr_mut(&mut binary.left);
                self.visit_expr_mut(&mut binary.right);
                let Expr::Binary(old) = &right else { return };
                let with = |op: BinOp| -> Expr {
                    let mut other = old.clone();
                    other.op = op;
                    Expr::Binary(other)
                };
                let compared = comparisons(&old.op);
                if !compared.is_empty() {
                    let wrong = compared.into_iter().map(with).collect();
                    self.choose("comparison", place, &right, wrong);
                } else if matches!(old.op, BinOp::And(_)) {
                    self.choose(
                        "logic",
                        place,
                        &right,
                        vec![
                            with(parse_quote!(||)),
                            (*old.left).clone(),
                            (*old.right).clone(),
                        ],
                    );
                } else if matches!(old.op, BinOp::Or(_)) {
                    self.choose(
                        "logic",
                        place,
                        &right,
                        vec![
                            with(parse_quote!(&&)),
                            (*old.left).clone(),
                            (*old.right).clone(),
                        ],
                    );
                } else if let Some(op) = arithmetic(&old.op) {
                    self.choose("arithmetic", place, &right, vec![with(op)]);
                }
            }
            Expr::Unary(unary) => {
                self.visit_expr_mut(&mut unary.expr);
                if let (UnOp::Not(_), Expr::Unary(old)) = (&unary.op, &right) {
                    self.choose("logic", place, &right, vec![(*old.expr).clone()]);
                }
            }
            Expr::If(branch) => {
                self.condition(&mut branch.cond);
                self.visit_block_mut(&mut branch.then_branch);
                if let Some((_, other)) = &mut branch.else_branch {
                    self.visit_expr_mut(other);
                }
            }
            Expr::While(repeated) => {
                if has_let(&repeated.cond) {
                    self.condition(&mut repeated.cond);
                } else {
                    let condition = (*repeated.cond).clone();
                    self.visit_expr_mut(&mut repeated.cond);
                    self.choose(
                        "condition",
                        &mut repeated.cond,
                        &condition,
                        vec![parse_quote!(false)],
                    );
                }
                self.visit_block_mut(&mut repeated.body);
            }
            Expr::ForLoop(repeated) => {
                let over = (*repeated.expr).clone();
                PathChanger.visit_pat_mut(&mut repeated.pat);
                self.visit_expr_mut(&mut repeated.expr);
                let wrong =
                    ["over nothing", "all but the first", "the first only"].map(str::to_owned);
                let question = self.note("loop", &over, &wrong);
                let now = &repeated.expr;
                *repeated.expr = parse_quote!(crate::switch::shortened(#now, #question));
                self.visit_block_mut(&mut repeated.body);
            }
            Expr::Closure(closure) => {
                for input in &mut closure.inputs {
                    PathChanger.visit_pat_mut(input);
                }
                self.visit_expr_mut(&mut closure.body);
            }
            Expr::MethodCall(call) => {
                self.visit_expr_mut(&mut call.receiver);
                if let Some(turbofish) = &mut call.turbofish {
                    PathChanger.visit_angle_bracketed_generic_arguments_mut(turbofish);
                }
                let predicate = PREDICATES.iter().any(|p| call.method == p);
                for argument in &mut call.args {
                    match argument {
                        Expr::Closure(closure)
                            if predicate && !matches!(*closure.body, Expr::Block(_)) =>
                        {
                            for input in &mut closure.inputs {
                                PathChanger.visit_pat_mut(input);
                            }
                            self.condition(&mut closure.body);
                        }
                        Expr::Closure(closure) if predicate => {
                            self.visit_expr_mut(&mut closure.body);
                            if let Expr::Block(block) = &mut *closure.body
                                && let Some(Stmt::Expr(tail, None)) = block.block.stmts.last_mut()
                            {
                                let all = tail.clone();
                                self.choose(
                                    "condition",
                                    tail,
                                    &quiet(&all),
                                    vec![parse_quote!(true), parse_quote!(false)],
                                );
                            }
                        }
                        _ => self.visit_expr_mut(argument),
                    }
                }
                let Expr::MethodCall(old) = &right else {
                    return;
                };
                let method = old.method.to_string();
                let quantifier = matches!(old.args.first(), Some(Expr::Closure(_) | Expr::Path(_)));
                if (method == "any" || method == "all") && !quantifier {
                    return;
                }
                if method == "chain" && old.args.len() == 1 {
                    let question = self.note("loop", old, &["without the second part".to_owned()]);
                    let Expr::MethodCall(call) = place else {
                        return;
                    };
                    let second = call.args[0].clone();
                    call.args[0] = parse_quote!(crate::switch::shortened(#second, #question));
                    return;
                }
                let renamed = |name: &str| -> Expr {
                    let mut other = old.clone();
                    other.method = Ident::new(name, Span::call_site());
                    Expr::MethodCall(other)
                };
                if method == "and" && old.args.len() == 2 {
                    let (a, b) = (&old.args[0], &old.args[1]);
                    let one = |x: &Expr| -> Expr {
                        parse_quote!(::core::result::Result::<_, linewright::game::Limit>::Ok((#x).clone()))
                    };
                    self.choose("set", place, &right, vec![one(a), one(b)]);
                } else if (method == "or" || method == "and_not") && old.args.len() == 2 {
                    let (other, a) = (METHODS.iter().find(|(m, _)| *m == method), &old.args[0]);
                    let first: Expr = parse_quote!(::core::result::Result::<_, linewright::game::Limit>::Ok((#a).clone()));
                    let wrong = other
                        .map(|(_, w)| renamed(w))
                        .into_iter()
                        .chain([first])
                        .collect();
                    self.choose("set", place, &right, wrong);
                } else if method == "prime" && old.args.len() == 1 {
                    let a = &old.args[0];
                    let same: Expr = parse_quote!(::core::result::Result::<_, linewright::game::Limit>::Ok((#a).clone()));
                    self.choose("set", place, &right, vec![same]);
                } else if let Some((_, other)) = METHODS.iter().find(|(m, _)| *m == method) {
                    self.choose("quantifier", place, &right, vec![renamed(other)]);
                }
            }
            Expr::Match(chosen) => {
                self.visit_expr_mut(&mut chosen.expr);
                let names: Vec<Ident> = chosen
                    .arms
                    .iter()
                    .filter_map(|a| arm_name(a).cloned())
                    .collect();
                for arm in &mut chosen.arms {
                    let name = arm_name(arm).cloned();
                    self.visit_arm_mut(arm);
                    let other = names.iter().find(|n| Some(*n) != name.as_ref());
                    if let (Some(name), Some(other)) = (name, other) {
                        let pattern = &arm.pat;
                        let right: Expr = parse_quote!(#name);
                        let shown = format!("{} => {other}", shown(pattern));
                        let question = self.note("arm", &quote!(#pattern => #right), &[shown]);
                        *arm.body = parse_quote!((if #question == 1 { #other } else { #name }));
                    }
                }
            }
            Expr::Lit(ExprLit {
                lit: Lit::Bool(value),
                ..
            }) => {
                let other: Expr = if value.value {
                    parse_quote!(false)
                } else {
                    parse_quote!(true)
                };
                self.choose("constant", place, &right, vec![other]);
            }
            Expr::Lit(ExprLit {
                lit: Lit::Int(number),
                ..
            }) => {
                let value: u64 = number.base10_parse().unwrap_or(0);
                let other = if value == 1 { 0 } else { value + 1 };
                let other = syn::LitInt::new(&format!("{other}{}", number.suffix()), number.span());
                self.choose("constant", place, &right, vec![parse_quote!(#other)]);
            }
            Expr::Path(path) => {
                let names: Vec<String> = path
                    .path
                    .segments
                    .iter()
                    .map(|s| s.ident.to_string())
                    .collect();
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let other: Option<Expr> = match names[..] {
                    ["Time", "Now"] => Some(parse_quote!(Time::Next)),
                    ["Time", "Next"] => Some(parse_quote!(Time::Now)),
                    ["Owner", "Environment"] => Some(parse_quote!(Owner::System)),
                    ["Owner", "System"] => Some(parse_quote!(Owner::Environment)),
                    _ => None,
                };
                PathChanger.visit_expr_path_mut(path);
                if let Some(other) = other {
                    self.choose("constant", place, &right, vec![other]);
                }
            }
            // The length of an array is part of its type.
            Expr::Repeat(repeat) => self.visit_expr_mut(&mut repeat.expr),
            // The left side of an assignment is a place in memory.
            Expr::Assign(assigned) => {
                PathChanger.visit_expr_mut(&mut assigned.left);
                self.visit_expr_mut(&mut assigned.right);
            }
            _ => visit_mut::visit_expr_mut(self, place),
        }
        // Alternatives are made of the original code.
        PathChanger.visit_expr_mut(place);
    }
}

/// For the list: a tail that already has switches is shown without them.
fn quiet(tail: &Expr) -> Expr {
    let text = shown(tail);
    if text.contains("switch") {
        return parse_quote!(the_last_expression_of_the_predicate);
    }
    tail.clone()
}

/// Replaces the beginning of paths.
struct PathChanger;

impl VisitMut for PathChanger {
    fn visit_path_mut(&mut self, path: &mut syn::Path) {
        if let Some(first) = path.segments.first_mut()
            && first.ident == "crate"
            && path
                .segments
                .iter()
                .nth(1)
                .is_none_or(|s| s.ident != "switch")
        {
            path.segments[0].ident = Ident::new("linewright", Span::call_site());
        }
        visit_mut::visit_path_mut(self, path);
    }

    fn visit_use_tree_mut(&mut self, tree: &mut syn::UseTree) {
        if let syn::UseTree::Path(path) = tree
            && path.ident == "crate"
        {
            path.ident = Ident::new("linewright", Span::call_site());
        }
    }
}
