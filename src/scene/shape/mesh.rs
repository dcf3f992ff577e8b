//! Meshes from files: `mesh, "FILE"`.

use crate::lang::cursor::{Cursor, Reported};
use crate::lang::keywords::Keyword;
use crate::lang::source::SourceSpan;
use crate::lang::token::Mark;
use crate::scene::movable::Movable;
use crate::scene::named_file::NamedFile;
use crate::scene::syntax::TextForm;
use glam::DVec3;
use std::fmt::{Display, Formatter, Result as FmtResult};

/// A mesh that a file holds. The scene only names it; see [`World::new`](crate::world::World::new) for its triangles.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedMesh(NamedFile);

impl NamedMesh {
    /// A mesh of this name; `None` if a scene cannot write the name: it is empty, has blanks around it, a quotation
    /// mark or a line end.
    pub fn new(path: impl Into<String>) -> Option<Self> {
        NamedFile::new(path).map(Self)
    }

    /// The name as it stands in the scene: a path from the folder of the scene, or `preset:NAME`. It has no quotation
    /// mark and no line end.
    pub fn path(&self) -> &str {
        self.0.path()
    }

    /// Where the name stands in the text, with its quotation marks.
    pub fn span(&self) -> SourceSpan {
        self.0.span()
    }
}

impl Movable for NamedMesh {
    /// The origin of its coordinates.
    fn anchor(&self) -> Option<DVec3> {
        Some(DVec3::ZERO)
    }

    /// A mesh is where its file says. Transforms move it.
    fn moved(&self, _: DVec3) -> Option<Self> {
        None
    }
}

impl TextForm for NamedMesh {
    const KEYWORD: Keyword = Keyword {
        word: "mesh",
        doc: "`mesh, \"FILE\"`: triangles from an OBJ, PLY, STL or glTF file, whose path is from the scene file",
    };
    const CLAUSES: &'static [Keyword] = &[];
    const EXAMPLE: &'static str = "mesh, \"preset:gem\"";

    fn parse(cursor: &mut Cursor) -> Result<Option<Self>, Reported> {
        cursor.expect(Mark::Comma, "after `mesh`")?;
        cursor.pass_marks_after("mesh,", &[Mark::Equal]);
        Ok(NamedFile::parse(cursor, "mesh", "mesh, \"FILE.obj\"")?.map(Self))
    }
}

impl Display for NamedMesh {
    fn fmt(&self, f: &mut Formatter<'_>) -> FmtResult {
        write!(f, "mesh, {}", self.0)
    }
}
