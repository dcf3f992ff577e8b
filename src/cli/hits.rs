//! `illuminator dump --stage hits`: everything that tracing found, as columns of numbers for other programs.
//!
//! There are four tables, and a little-endian file without a header for each column. `index.json`, which is written
//! last, gives names, types and counts, and the weight of a pass:
//!
//! - `hits`: pixel (row by row from the top left), pass, body, path, primitive, and the variables of the hit;
//! - `records`: a hit and a light that reaches it, the variables of both, and the radiance and the weight of the sample
//!   of the light. If the formula reads `visible`, there is a record for each hit and each light;
//! - `misses`: rays that left the scene, by pixel, pass and path;
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
use illuminator::lang::types::Type;
use illuminator::lang::variables::{Rate, Variable};
use illuminator::sampling::SampleKey;
use illuminator::trace::{CoordinatesUse, Edge, HitVariables, Hits, LightVariables, NodeLight, Tile, Tracer, replay, variable};
use illuminator::workspace::project::Project;
use illuminator::world::SurfaceHit;
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

/// The file that gives names, types and counts of the columns.
const INDEX: &str = "index.json";

/// Stands for "none": no path before (the camera), no body (the ray left the scene).
const NONE: u32 = u32::MAX;

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
        let mut dump = None;
        for pass in 0..passes {
            let tell = |share: f64| progress.tell((f64::from(pass) + share) / f64::from(passes));
            let hits = traced(&engine, &input.subject, pass, &Task::watched(&tell))?;
            // What an earlier run wrote stays if nothing can be traced.
            let dump = match &mut dump {
                Some(dump) => dump,
                None => dump.insert(Dump::new(folder).map_err(failed)?),
            };
            dump.pass(&hits).map_err(failed)?;
        }
        dump.map_or(Ok(()), |dump| dump.finish(&input.subject, passes, folder)).map_err(failed)
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
    name: String,
    file: String,
    r#type: &'static str,
    /// How many numbers each row has. They are stored together.
    components: usize,
    /// What it means.
    #[serde(skip_serializing_if = "Option::is_none")]
    meaning: Option<&'static str>,
}

/// What a column of whole numbers means.
fn meaning(table: &str, column: &str) -> Option<&'static str> {
    Some(match (table, column) {
        ("paths", "parent") => "the path to the hit that the last ray comes from; none: the camera",
        ("paths", "edge") => {
            "how the last ray came to be; reflected and refracted ones are weighed with kr or kt of the parent's body"
        }
        ("paths", "body") => "the body that the last ray hit; none: it left the scene",
        ("hits", "pixel") | ("misses", "pixel") => "the pixel, counted row by row from the top left",
        ("hits", "pass") | ("misses", "pass") => "the pass, counted from 0; the picture is the mean of all passes",
        ("hits", "path") | ("misses", "path") => {
            "the path by which the ray came; its weight is the product of kr and kt along it"
        }
        ("hits", "body") => "the body",
        ("hits", "primitive") => "the part of the body's surface, counted from 0: a side of a box, a triangle of a mesh",
        ("records", "hit") => "the hit that the light reaches, or may reach: see `visible`",
        ("records", "light") => "the light",
        _ => return None,
    })
}

/// The variables of the sample of a light, which formulas do not read by name, each with the name of its column.
const OF_SAMPLE: [(Variable, &str); 2] = [(Variable::Radiance, "radiance"), (Variable::SampleWeight, "weight")];

/// The name of the column of a variable.
fn column_of(variable: Variable) -> &'static str {
    OF_SAMPLE.iter().find(|(of_sample, _)| *of_sample == variable).map_or(variable.name(), |(_, name)| *name)
}

/// A table that is being written: one file a column.
struct TableWriter {
    name: &'static str,
    count: u32,
    columns: Vec<(ColumnIndex, BufWriter<File>)>,
}

impl TableWriter {
    fn new(folder: &Path, name: &'static str, numbers: &[&str], variables: &[Variable]) -> io::Result<Self> {
        let whole = numbers.iter().map(|number| (*number, "u32", 1, meaning(name, number)));
        let real = variables.iter().map(|variable| (column_of(*variable), "f32", variable.ty().slots(), Some(variable.doc())));
        let column = |(column, r#type, components, meaning): (&str, &'static str, usize, Option<&'static str>)| {
            let file = format!("{name}.{column}.{type}");
            let writer = BufWriter::new(File::create(folder.join(&file))?);
            Ok((ColumnIndex { name: column.to_owned(), file, r#type, components, meaning }, writer))
        };
        Ok(TableWriter { name, count: 0, columns: whole.chain(real).map(column).collect::<io::Result<_>>()? })
    }

    /// Adds a row: the whole numbers, then the value of each variable. Returns the number of the row.
    fn add(&mut self, numbers: &[u32], variables: impl Iterator<Item = ([f32; 3], Type)>) -> io::Result<u32> {
        let row = self.count;
        self.count = row.checked_add(1).filter(|count| *count < NONE).ok_or_else(|| io::Error::other("too many rows"))?;
        let (whole, real) = self.columns.split_at_mut(numbers.len());
        for ((_, writer), number) in whole.iter_mut().zip(numbers) {
            writer.write_all(&number.to_le_bytes())?;
        }
        for ((_, writer), (value, ty)) in real.iter_mut().zip(variables) {
            for number in &value[..ty.slots()] {
                writer.write_all(&number.to_le_bytes())?;
            }
        }
        Ok(row)
    }

    fn finish(self) -> io::Result<(&'static str, TableIndex)> {
        let mut columns = Vec::new();
        for (column, mut writer) in self.columns {
            writer.flush()?;
            columns.push(column);
        }
        Ok((self.name, TableIndex { count: self.count, columns }))
    }
}

/// The tables while they are written.
struct Dump {
    hits: TableWriter,
    records: TableWriter,
    misses: TableWriter,
    paths: TableWriter,
    /// The row of each path by its last step.
    known: HashMap<(u32, Edge, u32), u32>,
    of_hit: Vec<Variable>,
    of_record: Vec<Variable>,
}

impl Dump {
    fn new(folder: &Path) -> io::Result<Self> {
        // A folder without an index is not a dump. So there is no index while columns are being overwritten.
        match fs::remove_file(folder.join(INDEX)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            Ok(()) | Err(_) => {}
        }
        let of = |rate| Variable::written().copied().filter(|variable| variable.rate() == rate).collect::<Vec<_>>();
        let (of_hit, mut of_record) = (of(Rate::Hit), of(Rate::Record));
        of_record.extend(OF_SAMPLE.map(|(variable, _)| variable));
        Ok(Self {
            hits: TableWriter::new(folder, "hits", &["pixel", "pass", "body", "path", "primitive"], &of_hit)?,
            records: TableWriter::new(folder, "records", &["hit", "light"], &of_record)?,
            misses: TableWriter::new(folder, "misses", &["pixel", "pass", "path"], &[])?,
            paths: TableWriter::new(folder, "paths", &["parent", "edge", "body"], &[])?,
            known: HashMap::new(),
            of_hit,
            of_record,
        })
    }

    /// Writes a pass.
    fn pass(&mut self, hits: &Hits) -> io::Result<()> {
        let tracer = Tracer::new(&hits.world, &hits.view);
        hits.tiles.iter().try_for_each(|tile| self.tile(&tracer, tile))
    }

    fn tile(&mut self, tracer: &Tracer, tile: &Tile) -> io::Result<()> {
        let mut rows: Vec<u32> = Vec::with_capacity(tile.paths.len());
        for path in &tile.paths {
            // Parents come before their children.
            let parent = path.parent.map_or(NONE, |parent| rows[parent.index()]);
            let step = (parent, path.edge, path.body.map_or(NONE, |body| body.0));
            let row = match self.known.get(&step) {
                Some(row) => *row,
                None => self.paths.add(&[step.0, step.1 as u32, step.2], std::iter::empty())?,
            };
            self.known.insert(step, row);
            rows.push(row);
        }
        // Scattered hits, which are in several groups, with all their emitters.
        let mut scattered: BTreeMap<(u32, u32), (SurfaceHit, SampleKey, Vec<NodeLight>)> = BTreeMap::new();
        for group in &tile.groups {
            for span in tile.spans_of(group) {
                let path = rows[span.path.index()];
                let mut outcome = Ok(());
                replay(tracer, tile, group, span.hits.clone(), |hit, key, surface| {
                    let lights = group.emitters.iter().map(|emitter| {
                        let visible = tile.is_visible(hit, *emitter);
                        NodeLight { emitter: *emitter, visible }
                    });
                    if group.scattered {
                        let (_, _, known) = scattered.entry((path, key.pixel)).or_insert_with(|| (*surface, *key, Vec::new()));
                        known.extend(lights);
                    } else if outcome.is_ok() {
                        outcome = self.hit(tracer, lights, surface, key, path);
                    }
                })
                .map_err(io::Error::other)?;
                outcome?;
            }
        }
        for ((path, _), (surface, key, lights)) in scattered {
            self.hit(tracer, lights, &surface, &key, path)?;
        }
        for span in &tile.misses {
            for segment in tile.miss_segments_of(span) {
                for pixel in segment.pixels() {
                    let (pixel, pass) = (tile.pixels.start + pixel as u32, tracer.view().pass());
                    self.misses.add(&[pixel, pass, rows[span.path.index()]], std::iter::empty())?;
                }
            }
        }
        Ok(())
    }

    fn hit(
        &mut self,
        tracer: &Tracer,
        lights: impl IntoIterator<Item = NodeLight>,
        surface: &SurfaceHit,
        key: &SampleKey,
        path: u32,
    ) -> io::Result<()> {
        let index = tracer.relative_index(surface);
        let own = HitVariables::new(tracer.world(), surface, index, CoordinatesUse::Read);
        let values = self.of_hit.iter().map(|symbol| (own.value(*symbol).unwrap_or_default(), symbol.ty()));
        let row = self.hits.add(&[key.pixel, key.pass, surface.body.0, path, surface.primitive.0], values)?;
        for NodeLight { emitter, visible } in lights {
            let lit = LightVariables::new(surface, &tracer.sample(emitter, surface, key), visible);
            let values = self.of_record.iter().map(|symbol| (variable(*symbol, &own, &lit), symbol.ty()));
            self.records.add(&[row, tracer.world().light_of(emitter).0], values)?;
        }
        Ok(())
    }

    /// Writes the index.
    fn finish(self, Subject { world, view, .. }: &Subject, passes: u32, folder: &Path) -> io::Result<()> {
        let tables = [self.hits, self.records, self.misses, self.paths];
        let scene = world.scene();
        let index = Index {
            version: 1,
            byte_order: "little",
            width: view.width(),
            height: view.height(),
            bodies: scene.bodies.iter().map(|body| body.name.clone()).collect(),
            lights: scene.lights.iter().map(|light| light.name.clone()).collect(),
            edges: ["primary", "reflected", "refracted"],
            none: NONE,
            passes: PassesIndex { count: passes, weight: f64::from(passes).recip() },
            tables: tables.into_iter().map(TableWriter::finish).collect::<io::Result<_>>()?,
        };
        replace_file(&folder.join(INDEX), |writer| serde_json::to_writer_pretty(writer, &index).map_err(io::Error::from))
    }
}
