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
use illuminator::lang::variables::{Rate, Variable};
use illuminator::sampling::SampleKey;
use illuminator::trace::{
    CoordinatesUse, Edge, HitVariables, Hits, LightVariables, NodeLight, Tile, Tracer, replay, replay_misses, variable,
};
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
    name: String,
    file: String,
    r#type: &'static str,
    /// How many numbers each row has. They are stored together.
    components: usize,
    /// What it means.
    #[serde(skip_serializing_if = "Option::is_none")]
    meaning: Option<&'static str>,
}

/// What a column means that has no variable.
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
        ("misses", "direction") => "the direction in which the ray left the scene",
        ("misses", "radiance") => "what the environment sends along the ray, as a factor of its ki and IL",
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

/// A column of real numbers.
struct RealColumn {
    name: &'static str,
    /// How many numbers each row has, 1..=3.
    components: usize,
    meaning: Option<&'static str>,
}

impl From<Variable> for RealColumn {
    fn from(variable: Variable) -> Self {
        Self { name: column_of(variable), components: variable.ty().slots(), meaning: Some(variable.doc()) }
    }
}

/// A table that is being written: one file a column.
struct TableWriter {
    name: &'static str,
    count: u32,
    columns: Vec<(ColumnIndex, BufWriter<File>)>,
}

impl TableWriter {
    fn new(folder: &Path, name: &'static str, numbers: &[&str], real: impl IntoIterator<Item = RealColumn>) -> io::Result<Self> {
        let whole = numbers.iter().map(|number| (*number, "u32", 1, meaning(name, number)));
        let real = real.into_iter().map(|RealColumn { name, components, meaning }| (name, "f32", components, meaning));
        let column = |(column, r#type, components, meaning): (&str, &'static str, usize, Option<&'static str>)| {
            let file = format!("{name}.{column}.{type}");
            let writer = BufWriter::new(File::create(folder.join(&file))?);
            Ok((ColumnIndex { name: column.to_owned(), file, r#type, components, meaning }, writer))
        };
        Ok(TableWriter { name, count: 0, columns: whole.chain(real).map(column).collect::<io::Result<_>>()? })
    }

    /// Adds a row: the whole numbers, then those of each real column, of which the first components count. Returns the
    /// number of the row.
    fn add(&mut self, numbers: &[u32], values: impl IntoIterator<Item = [f32; 3]>) -> io::Result<u32> {
        let row = self.count;
        self.count = row.checked_add(1).filter(|count| *count < NONE).ok_or_else(|| io::Error::other("too many rows"))?;
        let (whole, real) = self.columns.split_at_mut(numbers.len());
        for ((_, writer), number) in whole.iter_mut().zip(numbers) {
            writer.write_all(&number.to_le_bytes())?;
        }
        for ((column, writer), value) in real.iter_mut().zip(values) {
            for number in &value[..column.components] {
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
        let columns = |variables: &[Variable]| variables.iter().copied().map(RealColumn::from).collect::<Vec<_>>();
        let of_miss = ["direction", "radiance"].map(|name| RealColumn { name, components: 3, meaning: meaning("misses", name) });
        Ok(Self {
            hits: TableWriter::new(folder, "hits", &["pixel", "pass", "body", "path", "primitive"], columns(&of_hit))?,
            records: TableWriter::new(folder, "records", &["hit", "light"], columns(&of_record))?,
            misses: TableWriter::new(folder, "misses", &["pixel", "pass", "path"], of_miss)?,
            paths: TableWriter::new(folder, "paths", &["parent", "edge", "body"], [])?,
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
                None => self.paths.add(&[step.0, step.1 as u32, step.2], [])?,
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
        let environment = tracer.world().environment();
        for span in &tile.misses {
            let mut outcome = Ok(0);
            replay_misses(tracer, tile, span, |pixel, direction| {
                let radiance = environment.map_or([0.0; 3], |environment| environment.radiance(direction));
                if outcome.is_ok() {
                    let numbers = [pixel, tracer.view().pass(), rows[span.path.index()]];
                    outcome = self.misses.add(&numbers, [direction.as_vec3().to_array(), radiance]);
                }
            })
            .map_err(io::Error::other)?;
            outcome?;
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
        let values = self.of_hit.iter().map(|symbol| own.value(*symbol).unwrap_or_default());
        let row = self.hits.add(&[key.pixel, key.pass, surface.body.0, path, surface.primitive.0], values)?;
        for NodeLight { emitter, visible } in lights {
            let lit = LightVariables::new(surface, &tracer.sample(emitter, surface, key), visible);
            let values = self.of_record.iter().map(|symbol| variable(*symbol, &own, &lit));
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
            environment: world.environment().map(|environment| environment.light().0),
            edges: ["primary", "reflected", "refracted"],
            none: NONE,
            passes: PassesIndex { count: passes, weight: f64::from(passes).recip() },
            tables: tables.into_iter().map(TableWriter::finish).collect::<io::Result<_>>()?,
        };
        replace_file(&folder.join(INDEX), |writer| serde_json::to_writer_pretty(writer, &index).map_err(io::Error::from))
    }
}
