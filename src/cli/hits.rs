//! `illuminator dump --stage hits`: everything that tracing found, as columns of numbers for other programs.
//!
//! There are four tables, and a little-endian file without a header for each column. `index.json`, which is written
//! last, gives names, types and counts, and the weight of a pass:
//!
//! - `hits`: pixel (row by row from the top left), pass, body, path, primitive, and the variables of the hit;
//! - `records`: a hit and a light that reaches it, the variables of both, and the radiance and the weight of the sample
//!   of the light. If the formula reads `visible`, there is a record for each hit and each light;
//! - `misses`: rays that left the scene, by pixel, pass and path, their directions, and what the environment sends
//!   along them;
//! - `paths`: the last step of each path: the path before, the kind of ray, the body that it hit.
//!
//! One pass after the other is traced and written.

use crate::cli::engine;
use crate::cli::options::MachineOptions;
use crate::cli::output::check_folder;
use crate::cli::progress::Progress;
use crate::cli::report::Failure;
use illuminator::backends::REFERENCE;
use illuminator::engine::{Engine, Subject, Task};
use illuminator::files::{reason, replace_file};
use illuminator::trace::Hits;
use illuminator::trace::tables::{ColumnStore, EDGES, HitColumn, HitTable, HitTables, NONE};
use illuminator::workspace::project::Project;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The file that gives names, types and counts of the columns.
const INDEX: &str = "index.json";

/// Traces the scene and writes the hits.
pub(super) fn dump(input: &Project, machine: &MachineOptions, folder: &Path) -> Result<(), Failure> {
    let name = folder.display().to_string();
    fs::create_dir_all(folder)
        .map_err(|error| Failure::command_line(format!("cannot make the folder `{name}`: {}", reason(&error))))?;
    check_folder(folder)?;
    // The interpreter keeps no memory for hits.
    let engine = engine::engine(&REFERENCE, machine);
    let failed = |error: io::Error| Failure::input(format!("cannot write to `{name}`: {}", reason(&error)));
    engine::on_threads(machine, || {
        let passes = input.picture.passes();
        let progress = Progress::of_passes("tracing", passes);
        let mut written = None;
        for pass in 0..passes {
            let tell = |share: f64| progress.tell((f64::from(pass) + share) / f64::from(passes));
            let hits = traced(&engine, &input.subject, pass, &Task::watched(&tell))?;
            // What an earlier run wrote stays if nothing can be traced.
            let tables = match &mut written {
                Some(tables) => tables,
                None => written.insert(tables(folder).map_err(failed)?),
            };
            tables.add_pass(&hits, &AtomicBool::new(false)).map_err(failed)?;
        }
        written.map_or(Ok(()), |tables| finish(tables, &input.subject, passes, folder)).map_err(failed)
    })?
}

/// The hits of a pass.
fn traced(engine: &Engine, subject: &Subject, pass: u32, task: &Task) -> Result<Arc<Hits>, Failure> {
    let subject = Subject { view: subject.view.with_pass(pass), ..subject.clone() };
    let hits = engine.trace(&subject, task).map_err(engine::failed)?;
    hits.for_lights(subject.formula.evaluated_lights()).map_err(|error| Failure::input(error.to_string()))
}

/// What `index.json` says.
#[derive(Serialize)]
struct Index {
    version: u32,
    byte_order: &'static str,
    width: u32,
    height: u32,
    bodies: Vec<String>,
    lights: Vec<String>,
    /// The light that is the environment, if there is one.
    environment: Option<u32>,
    /// What the numbers of `paths.edge` mean.
    edges: [&'static str; 3],
    /// What stands for "none" in columns of type u32.
    none: u32,
    passes: PassesIndex,
    tables: BTreeMap<&'static str, TableIndex>,
}

/// The passes of the picture, which is their weighted sum.
#[derive(Serialize)]
struct PassesIndex {
    count: u32,
    /// The weight of each.
    weight: f64,
}

#[derive(Serialize)]
struct TableIndex {
    count: u32,
    columns: Vec<ColumnIndex>,
}

#[derive(Serialize)]
struct ColumnIndex {
    name: &'static str,
    file: String,
    r#type: &'static str,
    /// How many numbers each row has. They are stored together.
    components: usize,
    /// What it means.
    #[serde(skip_serializing_if = "Option::is_none")]
    meaning: Option<&'static str>,
}

/// A column that is being written to a file.
struct ColumnFile {
    /// The name of the file.
    name: String,
    writer: BufWriter<File>,
}

impl ColumnStore for ColumnFile {
    fn whole(&mut self, number: u32) -> io::Result<()> {
        self.writer.write_all(&number.to_le_bytes())
    }

    fn real(&mut self, numbers: &[f32]) -> io::Result<()> {
        numbers.iter().try_for_each(|number| self.writer.write_all(&number.to_le_bytes()))
    }
}

/// The tables, with files for their columns in a folder.
fn tables(folder: &Path) -> io::Result<HitTables<ColumnFile>> {
    // A folder without an index is not a dump. So there is no index while columns are being overwritten.
    match fs::remove_file(folder.join(INDEX)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        Ok(()) | Err(_) => {}
    }
    HitTables::new(&mut |table, column| {
        let name = format!("{table}.{}.{}", column.name, column.ty.name());
        let writer = BufWriter::new(File::create(folder.join(&name))?);
        Ok(ColumnFile { name, writer })
    })
}

/// What the index says about a table whose columns are complete.
fn table_index(table: HitTable<ColumnFile>) -> io::Result<(&'static str, TableIndex)> {
    let column = |(column, mut file): (HitColumn, ColumnFile)| {
        file.writer.flush()?;
        let HitColumn { name, ty, components, meaning } = column;
        Ok(ColumnIndex { name, file: file.name, r#type: ty.name(), components, meaning })
    };
    let columns = table.columns.into_iter().map(column).collect::<io::Result<_>>()?;
    Ok((table.name, TableIndex { count: table.count, columns }))
}

/// Writes the index.
fn finish(tables: HitTables<ColumnFile>, Subject { world, view, .. }: &Subject, passes: u32, folder: &Path) -> io::Result<()> {
    let scene = world.scene();
    let index = Index {
        version: 1,
        byte_order: "little",
        width: view.width(),
        height: view.height(),
        bodies: scene.bodies.iter().map(|body| body.name.clone()).collect(),
        lights: scene.lights.iter().map(|light| light.name.clone()).collect(),
        environment: world.environment().map(|environment| environment.light().0),
        edges: EDGES,
        none: NONE,
        passes: PassesIndex { count: passes, weight: f64::from(passes).recip() },
        tables: tables.tables().into_iter().map(table_index).collect::<io::Result<_>>()?,
    };
    replace_file(&folder.join(INDEX), |writer| serde_json::to_writer_pretty(writer, &index).map_err(io::Error::from))
}
