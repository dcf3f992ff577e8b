//! The modules of the crate, which of them import which, and where imports go round in a circle.

use super::tokens::{Token, tokens, without_tests};
use std::collections::{BTreeMap, BTreeSet};

/// The path of a module from the root of the crate: `lang`, `source`. The root has none.
pub(crate) type ModulePath = Vec<String>;

/// All modules, each with what it names of other modules.
pub(crate) struct Modules {
    modules: BTreeMap<ModulePath, Module>,
}

/// A module, which is a file.
#[derive(Default)]
struct Module {
    /// Names that `use` brings in, with the paths that they stand for.
    names: BTreeMap<String, Vec<String>>,
    /// Paths that are imported, or written out in the code, as they are written.
    paths: Vec<Vec<String>>,
}

/// Modules that import each other, directly or through others: the module that holds them, and their names.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Cycle {
    pub(crate) parent: String,
    pub(crate) members: BTreeSet<String>,
    /// Who imports what, a line for each.
    pub(crate) reasons: Vec<String>,
}

impl Modules {
    /// The modules of source files: paths below `src`, such as `lang/source.rs`, and texts. Modules that are compiled
    /// for tests alone are left out.
    pub(crate) fn new<'f>(files: impl IntoIterator<Item = (&'f str, &'f str)>) -> Self {
        let mut modules = BTreeMap::new();
        let mut tests = BTreeSet::new();
        for (file, text) in files {
            let path = module_path(file);
            let all = tokens(text);
            let kept = without_tests(&all);
            let declared = |tokens: &[Token]| -> BTreeSet<String> {
                tokens
                    .windows(2)
                    .filter(|two| two[0].word() == Some("mod"))
                    .filter_map(|two| two[1].word())
                    .map(str::to_owned)
                    .collect()
            };
            tests.extend(
                declared(&all).difference(&declared(&kept)).map(|name| [path.as_slice(), std::slice::from_ref(name)].concat()),
            );
            modules.insert(path, Module::new(&kept));
        }
        modules.retain(|path, _| !(1..=path.len()).any(|length| tests.contains(&path[..length])));
        Self { modules }
    }

    /// All modules but the root.
    pub(crate) fn paths(&self) -> impl Iterator<Item = &ModulePath> {
        self.modules.keys().filter(|path| !path.is_empty())
    }

    /// The rooms (modules in the root of the crate) that a module names.
    pub(crate) fn rooms_named_by(&self, path: &ModulePath) -> BTreeSet<String> {
        let absolute = self.modules[path].paths.iter().filter_map(|written| self.absolute(path, written));
        absolute.filter_map(|absolute| absolute.first().cloned()).collect()
    }

    /// The cycles of imports. A module and those below it count as one: a parent may use its children and they may use
    /// it. So cycles are those among the children of one module.
    pub(crate) fn cycles(&self) -> Vec<Cycle> {
        // By parent: from child to child, with a reason.
        let mut edges: BTreeMap<&[String], BTreeMap<(&str, String), String>> = BTreeMap::new();
        for (from, module) in &self.modules {
            for written in &module.paths {
                let Some(absolute) = self.absolute(from, written) else { continue };
                let to = self.owner(&absolute, 0);
                let common = from.iter().zip(&to).take_while(|(one, other)| one == other).count();
                if common == 0 || common == from.len() || common == to.len() {
                    continue;
                }
                let reason = format!("{} imports {}", from.join("::"), absolute.join("::"));
                edges.entry(&from[..common]).or_default().entry((&from[common], to[common].clone())).or_insert(reason);
            }
        }
        edges.into_iter().flat_map(|(parent, edges)| components(&parent.join("::"), &edges)).collect()
    }

    /// A path from the root of the crate for one that is written in a module; `None` for a path of another crate.
    fn absolute(&self, module: &ModulePath, written: &[String]) -> Option<Vec<String>> {
        let first = written.first()?.as_str();
        let mut base = match first {
            "crate" | "illuminator" => Vec::new(),
            "self" => module.clone(),
            "super" => module[..module.len().checked_sub(1)?].to_vec(),
            _ => {
                let child = [module.as_slice(), &written[..1]].concat();
                return self.modules.contains_key(&child).then(|| [module.as_slice(), written].concat());
            }
        };
        let mut rest = &written[1..];
        while rest.first().is_some_and(|next| next == "super") {
            base.pop()?;
            rest = &rest[1..];
        }
        base.extend_from_slice(rest);
        Some(base)
    }

    /// The module in which the item of a path is defined, as far as re-exports tell.
    fn owner(&self, absolute: &[String], depth: usize) -> ModulePath {
        let known = (0..=absolute.len()).rev().find(|length| self.modules.contains_key(&absolute[..*length])).unwrap_or(0);
        let module = absolute[..known].to_vec();
        let exported = absolute.get(known).and_then(|name| self.modules.get(&module)?.names.get(name));
        match exported.and_then(|written| self.absolute(&module, written)) {
            // Nobody re-exports through more modules. The limit ends the search for a name that stands for itself.
            Some(target) if depth < 8 => self.owner(&[target.as_slice(), &absolute[known + 1..]].concat(), depth + 1),
            _ => module,
        }
    }
}

/// The path of the module in a file.
fn module_path(file: &str) -> ModulePath {
    let mut path: ModulePath = file.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if path.last().is_some_and(|last| last == "mod") || ["lib", "main"].map(|root| vec![root.to_owned()]).contains(&path) {
        path.pop();
    }
    path
}

impl Module {
    fn new(tokens: &[Token]) -> Self {
        let mut module = Self::default();
        let mut at = 0;
        while at < tokens.len() {
            let word = tokens[at].word();
            if word == Some("use") {
                at += 1;
                at += module.read_use(&tokens[at..], &mut Vec::new());
            } else if word.is_some_and(|word| ["crate", "self", "super"].contains(&word)) {
                let path = path_at(&tokens[at..]);
                at += 2 * path.len() - 1;
                if path.len() > 1 {
                    module.paths.push(path);
                }
            } else {
                at += 1;
            }
        }
        module
    }

    /// Reads what stands behind `use`, or an element of a group in it, below a path. How many tokens were read.
    fn read_use(&mut self, tokens: &[Token], path: &mut Vec<String>) -> usize {
        let before = path.len();
        let mut at = 0;
        loop {
            match tokens.get(at) {
                Some(Token::PathSeparator) => at += 1,
                Some(Token::Word(word)) if word == "as" => {
                    let name = tokens.get(at + 1).and_then(Token::word).unwrap_or_default().to_owned();
                    self.add(name, path);
                    path.truncate(before);
                    return at + 2;
                }
                Some(Token::Word(word)) => {
                    // `a::{self}` is `a`.
                    if word != "self" || path.is_empty() {
                        path.push(word.clone());
                    }
                    at += 1;
                }
                Some(Token::Mark('{')) => {
                    at += 1;
                    while !matches!(tokens.get(at), Some(Token::Mark('}')) | None) {
                        at += self.read_use(&tokens[at..], path).max(1);
                    }
                    path.truncate(before);
                    return at + 1;
                }
                Some(Token::Mark('*')) => {
                    self.paths.push(path.clone());
                    path.truncate(before);
                    return at + 1;
                }
                // The end of an element, of a group or of all.
                Some(Token::Mark(_)) | None => {
                    if path.len() > before || before > 0 && at > 0 {
                        self.add(path.last().cloned().unwrap_or_default(), path);
                    }
                    path.truncate(before);
                    return at;
                }
            }
        }
    }

    fn add(&mut self, name: String, path: &[String]) {
        self.names.insert(name, path.to_vec());
        self.paths.push(path.to_vec());
    }
}

/// The path that begins here: words with `::` between them.
fn path_at(tokens: &[Token]) -> Vec<String> {
    let mut path: Vec<String> = tokens.first().and_then(Token::word).map(str::to_owned).into_iter().collect();
    for two in tokens[1..].chunks(2) {
        match two {
            [Token::PathSeparator, Token::Word(word)] => path.push(word.clone()),
            _ => break,
        }
    }
    path
}

/// The sets of two and more names that reach each other.
fn components(parent: &str, edges: &BTreeMap<(&str, String), String>) -> Vec<Cycle> {
    let reached_from = |start: &str| {
        let mut reached = BTreeSet::new();
        let mut open = vec![start.to_owned()];
        while let Some(from) = open.pop() {
            for (_, to) in edges.keys().filter(|(other, _)| *other == from) {
                if reached.insert(to.clone()) {
                    open.push(to.clone());
                }
            }
        }
        reached
    };
    let reach: BTreeMap<&str, BTreeSet<String>> = edges.keys().map(|(from, _)| (*from, reached_from(from))).collect();
    let mut found = BTreeSet::new();
    for (name, reached) in &reach {
        let members: BTreeSet<String> =
            reached.iter().filter(|other| reach.get(other.as_str()).is_some_and(|back| back.contains(*name))).cloned().collect();
        if !members.is_empty() {
            let inside = edges.iter().filter(|((from, to), _)| members.contains(*from) && members.contains(to));
            found.insert(Cycle {
                parent: parent.to_owned(),
                reasons: inside.map(|(_, reason)| reason.clone()).collect(),
                members,
            });
        }
    }
    found.into_iter().collect()
}

#[cfg(test)]
fn cycles_of(files: &[(&str, &str)]) -> Vec<String> {
    let cycles = Modules::new(files.iter().copied()).cycles();
    cycles.into_iter().map(|cycle| format!("{}: {}", cycle.parent, Vec::from_iter(cycle.members).join(" "))).collect()
}

#[test]
fn every_way_to_import_is_seen() {
    let other = ("a/other.rs", "pub struct T; use crate::a::one::S;");
    let root = ("a/mod.rs", "mod one; mod other; pub use other::T as Renamed;");
    for import in [
        "use crate::a::other::T;",
        "use crate::{b, a::{c, other::{self, T}}};",
        "use crate::a::{other::*};",
        "use super::other::T;",
        "use super::{other as o, x};",
        "use self::super::other;",
        "fn f() -> super::other::T {}",
        "fn f() -> crate::a::other::T {}",
        "pub(crate) use crate::a::other;",
        "use crate::a::Renamed;",
        "use super::Renamed;",
        "fn f() { crate::a::Renamed::new() }",
        "macro_rules! m { () => { $crate::a::other::T } }",
    ] {
        assert_eq!(cycles_of(&[root, other, ("a/one.rs", import)]), ["a: one other"], "{import}");
    }
    for import in [
        "// use crate::a::other::T;",
        "const T: &str = \"crate::a::other::T\";",
        "#[cfg(test)] mod tests { use super::super::other::T; }",
        "use crate::a::one::inner::T; use super::A; use std::{fmt, other}; use other::T;",
        "pub(crate) fn f() {}",
    ] {
        assert_eq!(cycles_of(&[root, other, ("a/one.rs", import)]), [""; 0], "{import}");
    }
}

#[test]
fn cycles_are_found_between_folders_and_over_several_modules() {
    let files = [
        ("lib.rs", "mod a;"),
        ("a/x.rs", "use super::y::deep::Y;"),
        ("a/y/mod.rs", "mod deep; mod tests;"),
        ("a/y/deep.rs", "use crate::a::z;"),
        ("a/z.rs", "use crate::a::x::X;"),
        ("a/w.rs", "use crate::a::x::X; use crate::b::B;"),
        ("b/mod.rs", "use crate::a::w;"),
    ];
    assert_eq!(cycles_of(&files), ["a: x y z"]);
    assert_eq!(cycles_of(&files[..4]), [""; 0]);
    let modules = Modules::new(files);
    assert_eq!(modules.rooms_named_by(&module_path("a/w.rs")), ["a", "b"].map(str::to_owned).into());
}

#[test]
fn modules_for_tests_alone_are_left_out() {
    let files = [
        ("a/mod.rs", "mod x; mod y;"),
        ("a/x.rs", "use super::y; #[cfg(test)] mod tests;"),
        ("a/y.rs", ""),
        ("a/x/tests.rs", ""),
    ];
    assert_eq!(Modules::new(files).paths().map(|path| path.join("::")).collect::<Vec<_>>(), ["a", "a::x", "a::y"]);
    let cyclic = [files[0], files[1], files[2], ("a/y/tests.rs", "use crate::a::x;"), ("a/y.rs", "#[cfg(test)] mod tests;")];
    assert_eq!(cycles_of(&cyclic), [""; 0]);
}
