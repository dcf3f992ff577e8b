//! The hits of a picture as tables: columns of numbers for a notebook, a file or another renderer.
//!
//! - `hits`: a row for each hit: pixel, pass, body, path, and the variables that are the same for all lights;
//! - `records`: a row for each hit and each light that reaches it, with the variables of the light. A formula that
//!   reads `visible` is evaluated at every light, so for it there is a row for each hit and each light;
//! - `misses`: rays that left the scene, by pixel, pass and path, their directions, and what the environment sends
//!   along them;
//! - `paths`: the last step of each path: the path before, the kind of ray, the body that it hit.
//!
//! One pass after the other is added. Where the numbers go is up to the caller, see [`ColumnStore`].

use crate::lang::variables::{Rate, Variable};
use crate::sampling::SampleKey;
use crate::trace::lookup::variable;
use crate::trace::replay::{replay, replay_misses};
use crate::trace::store::{Counts, Hits, Tile};
use crate::trace::tracer::{NodeLight, Tracer};
use crate::trace::variables::{CoordinatesUse, HitVariables, LightVariables};
use crate::trace::walk::Edge;
use crate::world::SurfaceHit;
use std::collections::{BTreeMap, HashMap};
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stands for "none": no path before (the camera), no body (the ray left the scene).
pub const NONE: u32 = u32::MAX;

/// The names of the numbers in the column `edge` of the paths: 0, 1, 2.
pub const EDGES: [&str; 3] = ["primary", "reflected", "refracted"];

/// Takes the numbers of a column, row by row.
pub trait ColumnStore {
    /// Takes a whole number.
    ///
    /// # Errors
    /// It cannot be stored.
    fn whole(&mut self, number: u32) -> io::Result<()>;

    /// Takes the numbers of a row, as many as the column has components.
    ///
    /// # Errors
    /// They cannot be stored.
    fn real(&mut self, numbers: &[f32]) -> io::Result<()>;
}

/// The type of a column's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnType {
    /// Whole numbers. [`NONE`] stands for none.
    U32,
    /// Real numbers.
    F32,
}

impl ColumnType {
    /// How programs call it.
    pub fn name(self) -> &'static str {
        match self {
            ColumnType::U32 => "u32",
            ColumnType::F32 => "f32",
        }
    }
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HitColumn {
    /// Its name: that of a variable if it holds one.
    pub name: &'static str,
    /// The type of its numbers.
    pub ty: ColumnType,
    /// How many numbers each row has, 1..=3. They are stored together.
    pub components: usize,
    /// What it means.
    pub meaning: Option<&'static str>,
}

impl HitColumn {
    fn whole(table: &'static str, name: &'static str) -> Self {
        Self { name, ty: ColumnType::U32, components: 1, meaning: meaning(table, name) }
    }

    fn of(variable: Variable) -> Self {
        let components = variable.ty().slots();
        Self { name: column_of(variable), ty: ColumnType::F32, components, meaning: Some(variable.doc()) }
    }
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

/// A table: columns with as many rows each.
pub struct HitTable<C> {
    /// Its name.
    pub name: &'static str,
    /// How many rows it has, less than [`NONE`].
    pub count: u32,
    /// The columns and their numbers. Those of whole numbers come first.
    pub columns: Vec<(HitColumn, C)>,
}

impl<C: ColumnStore> HitTable<C> {
    fn new(
        name: &'static str,
        whole: &[&'static str],
        real: impl IntoIterator<Item = HitColumn>,
        store: &mut dyn FnMut(&'static str, &HitColumn) -> io::Result<C>,
    ) -> io::Result<Self> {
        let columns = whole.iter().map(|column| HitColumn::whole(name, column)).chain(real);
        let columns = columns.map(|column| Ok((column, store(name, &column)?))).collect::<io::Result<_>>()?;
        Ok(Self { name, count: 0, columns })
    }

    /// Adds a row: the whole numbers, then those of each real column, of which the first components count. Returns the
    /// number of the row.
    fn add(&mut self, numbers: &[u32], values: impl IntoIterator<Item = [f32; 3]>) -> io::Result<u32> {
        let row = self.count;
        self.count = row.checked_add(1).filter(|count| *count < NONE).ok_or_else(|| io::Error::other("too many rows"))?;
        let (whole, real) = self.columns.split_at_mut(numbers.len());
        for ((_, store), number) in whole.iter_mut().zip(numbers) {
            store.whole(*number)?;
        }
        for ((column, store), value) in real.iter_mut().zip(values) {
            store.real(&value[..column.components])?;
        }
        Ok(row)
    }
}

/// The tables while they are made.
pub struct HitTables<C> {
    hits: HitTable<C>,
    records: HitTable<C>,
    misses: HitTable<C>,
    paths: HitTable<C>,
    /// The row of each path by its last step.
    known: HashMap<(u32, Edge, u32), u32>,
    of_hit: Vec<Variable>,
    of_record: Vec<Variable>,
}

impl<C: ColumnStore> HitTables<C> {
    /// Empty tables. `store` makes the store of a column of the table of this name.
    ///
    /// # Errors
    /// A store cannot be made.
    pub fn new(store: &mut dyn FnMut(&'static str, &HitColumn) -> io::Result<C>) -> io::Result<Self> {
        let of = |rate| Variable::written().copied().filter(|variable| variable.rate() == rate).collect::<Vec<_>>();
        let (of_hit, mut of_record) = (of(Rate::Hit), of(Rate::Record));
        of_record.extend(OF_SAMPLE.map(|(variable, _)| variable));
        let columns = |variables: &[Variable]| variables.iter().copied().map(HitColumn::of).collect::<Vec<_>>();
        let of_miss = ["direction", "radiance"];
        let of_miss =
            of_miss.map(|name| HitColumn { name, ty: ColumnType::F32, components: 3, meaning: meaning("misses", name) });
        Ok(Self {
            hits: HitTable::new("hits", &["pixel", "pass", "body", "path", "primitive"], columns(&of_hit), store)?,
            records: HitTable::new("records", &["hit", "light"], columns(&of_record), store)?,
            misses: HitTable::new("misses", &["pixel", "pass", "path"], of_miss, store)?,
            paths: HitTable::new("paths", &["parent", "edge", "body"], [], store)?,
            known: HashMap::new(),
            of_hit,
            of_record,
        })
    }

    /// The tables: hits, records, misses and paths.
    pub fn tables(self) -> [HitTable<C>; 4] {
        [self.hits, self.records, self.misses, self.paths]
    }

    /// The bytes of all numbers if a pass with these counts is added. Those of paths, which are few, are left out.
    pub fn bytes_with(&self, counts: &Counts) -> u64 {
        let tables = [(&self.hits, counts.hits), (&self.records, counts.records), (&self.misses, counts.misses)];
        let bytes = |(table, more): (&HitTable<C>, u64)| {
            let row = table.columns.iter().map(|(column, _)| column.components as u64).sum::<u64>() * size_of::<f32>() as u64;
            (u64::from(table.count) + more) * row
        };
        tables.into_iter().map(bytes).sum()
    }

    /// Adds the hits of a pass.
    ///
    /// # Errors
    /// Numbers cannot be stored, there are too many rows, or the work was cancelled.
    pub fn add_pass(&mut self, hits: &Hits, cancelled: &AtomicBool) -> io::Result<()> {
        let tracer = Tracer::new(&hits.world, &hits.view);
        hits.tiles.iter().try_for_each(|tile| match cancelled.load(Ordering::Relaxed) {
            true => Err(io::Error::other("it was cancelled")),
            false => self.tile(&tracer, tile),
        })
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
}
