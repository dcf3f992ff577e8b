//! A third backend, for tests, in plain Rust. It reads the plans and computes one operation at a time over whole
//! columns.
//!
//! It does what every backend must do: static and uniform values, contributions weighted by path, and images or the
//! live part for drags.

use illuminator::evaluate::DragBeginning;
use illuminator::evaluate::weights::{PathMonomials, Powers, Weight, path_weights};
use illuminator::evaluate::{
    Backend, Drag, Drawn, EvaluateError, Evaluator, Footprint, Framebuffer, equation_in, evaluated_formula,
};
use illuminator::formula::equation::{Equation, Site};
use illuminator::formula::graph::{Graph, Node, NodeId};
use illuminator::formula::{Formula, Parameter, ParameterId};
use illuminator::lang::scalars::{Floats, flush};
use illuminator::lang::variables::{Owner, Variable};
use illuminator::picture::Frame;
use illuminator::plan::{ContributionPlan, DragPlan, FormulaPlan, KernelPlan, Method, SliderPlan, moved_parameters};
use illuminator::trace::{
    CoordinatesUse, Group, HitVariables, Hits, LightVariables, Tile, Tracer, View, replay, replay_misses, variable,
};
use illuminator::world::World;
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// One value for each record.
type Column = Vec<f32>;

/// The backend.
pub(super) struct ColumnsBackend;

impl Backend for ColumnsBackend {
    fn name(&self) -> &'static str {
        "columns"
    }

    fn compile(&self, _: &Arc<Formula>, _: &World) -> Result<Footprint, EvaluateError> {
        Ok(Footprint::default())
    }

    fn thread_bytes(&self, _: &Arc<Formula>, _: &World, _: &View) -> Result<u64, EvaluateError> {
        Ok(0)
    }

    /// What a formula gives at every hit is not in this backend.
    fn prepare(&self, formula: &Arc<Formula>, hits: &Arc<Hits>, _: &[f32]) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        let formula = &evaluated_formula(formula, &hits.world);
        if !formula.surface.is_empty() {
            return Err(EvaluateError::Backend("this backend has no weights of rays".to_owned()));
        }
        let plan = FormulaPlan::new(formula);
        let hits = hits.for_lights(formula.evaluated_lights())?;
        let tracer = Tracer::new(&hits.world, &hits.view);
        let is_parameter = |leaf: NodeId| matches!(plan.bindings.graph.node(leaf), Node::Parameter(..));
        let reads_textures = plan.hits.inputs().chain(plan.records.inputs()).any(is_parameter);
        let columns = |tile: &Tile| {
            let of_group = |group| GroupColumns::new(&plan, &tracer, tile, group, &|_, _, _| 0.0);
            tile.groups.iter().map(of_group).collect::<Result<_, _>>()
        };
        let tiles = hits.tiles.iter().map(columns).collect::<Result<_, _>>()?;
        let equation = equation_in(formula, &hits.world);
        let parameters = formula.parameters.clone();
        Ok(Arc::new(ColumnsEvaluator { plan, equation, parameters, hits, tiles, reads_textures }))
    }
}

/// The static values of a group: the hit frontier, and for each emitter the record frontier.
struct GroupColumns {
    hits: Vec<Column>,
    records: Vec<Vec<Column>>,
}

impl GroupColumns {
    /// `texture` gives the number of a texture for a body and a light.
    fn new(
        plan: &FormulaPlan,
        tracer: &Tracer,
        tile: &Tile,
        group: &Group,
        texture: &dyn Fn(ParameterId, usize, usize) -> f32,
    ) -> Result<Self, EvaluateError> {
        let (graph, count) = (&plan.bindings.graph, group.hits.len());
        let [hit_leaves, record_leaves] = [&plan.hits, &plan.records].map(|plan| &plan.streams[0]);
        let mut hits = vec![Column::new(); hit_leaves.len()];
        let mut records = vec![vec![Column::new(); record_leaves.len()]; group.emitters.len()];
        replay(tracer, tile, group, group.hits.clone(), |hit, key, surface| {
            let index = tracer.relative_index(surface);
            let own = HitVariables::new(tracer.world(), surface, index, CoordinatesUse::Read);
            let leaf = |leaf: &NodeId, light: usize, value: &dyn Fn(Variable) -> [f32; 3]| match graph.node(*leaf) {
                Node::Variable(symbol, component) => flush(value(symbol)[usize::from(component)]),
                Node::Parameter(id, _) => texture(id, group.body.index(), light),
                Node::Constant(_) | Node::Apply(..) => panic!("a leaf"),
            };
            for (column, node) in hits.iter_mut().zip(hit_leaves) {
                column.push(leaf(node, usize::MAX, &|symbol| own.value(symbol).expect("a variable of hits")));
            }
            for (emitter, columns) in group.emitters.iter().zip(&mut records) {
                let sample = tracer.sample(*emitter, surface, key);
                let lit = LightVariables::new(surface, &sample, tile.is_visible(hit, *emitter));
                let light = tracer.world().light_of(*emitter).index();
                for (column, node) in columns.iter_mut().zip(record_leaves) {
                    column.push(leaf(node, light, &|symbol| variable(symbol, &own, &lit)));
                }
            }
        })?;
        let hits = run(&plan.hits, graph, [&hits, &[], &[]], &[], count);
        let records = records.iter().map(|leaves| run(&plan.records, graph, [leaves, &[], &[]], &[], count)).collect();
        Ok(Self { hits, records })
    }
}

/// Runs a kernel over columns of `count` records.
fn run(plan: &KernelPlan, graph: &Graph, streams: [&[Column]; 3], uniforms: &[f32], count: usize) -> Vec<Column> {
    let mut values: HashMap<NodeId, Column> = HashMap::new();
    for (nodes, columns) in plan.streams.iter().zip(streams) {
        values.extend(nodes.iter().copied().zip(columns.iter().cloned()));
    }
    values.extend(plan.uniforms.iter().zip(uniforms).map(|(node, value)| (*node, vec![*value; count])));
    for id in plan.schedule(graph, plan.outputs.iter().copied()).expect("a plan reads what it needs") {
        let column = match graph.node(id) {
            Node::Constant(bits) => vec![f32::from_bits(bits); count],
            node @ Node::Apply(primitive, _) => {
                let operands: Vec<&Column> = node.operands().iter().map(|operand| &values[operand]).collect();
                let mut numbers = vec![0.0; operands.len()];
                let apply = |record: usize| {
                    numbers.iter_mut().zip(&operands).for_each(|(number, operand)| *number = operand[record]);
                    flush(primitive.apply(&mut Floats, &numbers))
                };
                (0..count).map(apply).collect()
            }
            Node::Variable(..) | Node::Parameter(..) => panic!("schedules hold no leaves"),
        };
        values.insert(id, column);
    }
    plan.outputs.iter().map(|output| values[output].clone()).collect()
}

/// A contribution, the pairs of a body and a light that it is active for, and the components that it computes.
struct Source<'s> {
    plan: &'s ContributionPlan,
    graph: &'s Graph,
    channels: Vec<usize>,
    active: Box<dyn Fn(usize, usize) -> bool + 's>,
    /// Whether its kernel reads the columns of a drag.
    drag_columns: Option<&'s ContributionPlan>,
}

/// What a pass adds up over all hits and misses.
struct Pass<'s> {
    sources: Vec<Source<'s>>,
    at_hits: Vec<[f32; 3]>,
    at_misses: [f32; 3],
    environment: [f32; 3],
}

struct ColumnsEvaluator {
    plan: FormulaPlan,
    equation: Equation,
    parameters: Vec<Parameter>,
    hits: Arc<Hits>,
    /// With white textures.
    tiles: Vec<Vec<GroupColumns>>,
    /// Whether static values are looked up in textures.
    reads_textures: bool,
}

impl ColumnsEvaluator {
    fn at_hits(&self, of_body: impl Fn(usize) -> [f32; 3]) -> Vec<[f32; 3]> {
        (0..self.equation.layout.owners(Owner::Body)).map(of_body).collect()
    }

    /// The uniform values of a contribution for a pair.
    fn uniforms(&self, plan: &ContributionPlan, graph: &Graph, parameters: &[f32], body: usize, light: usize) -> Vec<f32> {
        let leaves = plan.leaves(graph, &self.parameters).into_iter().map(|leaf| {
            let row = self.equation.layout.row(leaf.owner, [0, body, light][leaf.owner as usize]);
            vec![flush(parameters[row + leaf.slot])]
        });
        let leaves: Vec<Column> = leaves.collect();
        run(&plan.uniforms, graph, [&leaves, &[], &[]], &[], 1).concat()
    }

    /// The contributions of a source to the records of a group and an emitter.
    fn outputs(
        &self,
        graph: &Graph,
        plan: &ContributionPlan,
        drag_columns: &[Column],
        parameters: &[f32],
        indices: [usize; 3],
    ) -> Vec<Column> {
        let [tile, group, emitter] = indices;
        let of = &self.hits.tiles[tile].groups[group];
        let with_textures = self.reads_textures.then(|| {
            let tracer = Tracer::new(&self.hits.world, &self.hits.view);
            let texture = |id: ParameterId, body: usize, light: usize| {
                let parameter = &self.parameters[id.0 as usize];
                let owner = [0, body, light][parameter.owner as usize];
                flush(parameters[self.equation.layout.index(parameter, owner)])
            };
            GroupColumns::new(&self.plan, &tracer, &self.hits.tiles[tile], of, &texture).expect("hits of the scene")
        });
        let columns = with_textures.as_ref().unwrap_or(&self.tiles[tile][group]);
        let light = self.hits.world.light_of(of.emitters[emitter]);
        let uniforms = self.uniforms(plan, graph, parameters, of.body.index(), light.index());
        run(&plan.records, graph, [&columns.hits, &columns.records[emitter], drag_columns], &uniforms, of.hits.len())
    }

    /// Adds a pass to a picture; the weights of paths are given tile by tile.
    fn add(&self, pass: &Pass, parameters: &[f32], weights: &dyn Fn(&Tile) -> Vec<Weight>, picture: &mut [[f32; 3]]) {
        for (tile_index, tile) in self.hits.tiles.iter().enumerate() {
            let weights = weights(tile);
            let mut put = |pixel: usize, weight: Weight, colour: [f32; 3]| {
                let pixel = &mut picture[tile.pixels.start as usize + pixel];
                pixel.iter_mut().zip(weight.of(colour)).for_each(|(sum, component)| *sum += component);
            };
            for (group_index, group) in tile.groups.iter().enumerate() {
                let body = group.body.index();
                let mut sums = vec![[0.0; 3]; group.hits.len()];
                for source in &pass.sources {
                    for (emitter_index, emitter) in group.emitters.iter().enumerate() {
                        if !(source.active)(body, self.hits.world.light_of(*emitter).index()) {
                            continue;
                        }
                        let outputs = |plan, drag_columns: &[Column]| {
                            self.outputs(source.graph, plan, drag_columns, parameters, [tile_index, group_index, emitter_index])
                        };
                        let columns = outputs(
                            source.plan,
                            &source.drag_columns.map(|drag_columns| outputs(drag_columns, &[])).unwrap_or_default(),
                        );
                        for (channel, column) in source.channels.iter().zip(columns) {
                            sums.iter_mut().zip(column).for_each(|(sum, value)| sum[*channel] += value);
                        }
                    }
                }
                for span in tile.spans_of(group).iter().filter(|span| !weights[span.path.index()].is_zero()) {
                    let pixels = tile.segments_of(span).iter().flat_map(|segment| segment.pixels());
                    for (pixel, hit) in pixels.zip(span.hits.clone()) {
                        put(pixel, weights[span.path.index()], sums[(hit - group.hits.start) as usize]);
                    }
                }
            }
            // Terms without the formula are added for each path of a region, so that hits in several groups count once.
            let mut pixel = 0;
            let sets: Vec<_> = tile.path_sets.iter().collect();
            for region in &tile.regions {
                for _ in 0..region.pixels {
                    for path in sets[usize::from(region.set)].iter().filter(|path| !weights[path.index()].is_zero()) {
                        let colour = tile.paths[path.index()].body.map_or(pass.at_misses, |body| pass.at_hits[body.index()]);
                        put(pixel, weights[path.index()], colour);
                    }
                    pixel += 1;
                }
            }
            if let Some(environment) = self.hits.world.environment() {
                let tracer = Tracer::new(&self.hits.world, &self.hits.view);
                for span in tile.misses.iter().filter(|span| !weights[span.path.index()].is_zero()) {
                    let see = |pixel: u32, direction| {
                        let radiance = environment.radiance(direction);
                        let colour = [0, 1, 2].map(|component| pass.environment[component] * radiance[component]);
                        put((pixel - tile.pixels.start) as usize, weights[span.path.index()], colour);
                    };
                    replay_misses(&tracer, tile, span, see).expect("misses of the scene");
                }
            }
        }
    }

    fn is_on(&self, parameters: &[f32], light: usize) -> bool {
        self.equation.light_weight(parameters, light) != 0.0
    }

    /// The whole contribution, for some pairs.
    fn source<'s>(&'s self, active: impl Fn(usize, usize) -> bool + 's) -> Source<'s> {
        let (plan, graph) = (&self.plan.contribution, &self.plan.bindings.graph);
        Source { plan, graph, channels: vec![0, 1, 2], active: Box::new(active), drag_columns: None }
    }

    fn weights(&self, tile: &Tile, parameters: &[f32]) -> Vec<Weight> {
        let mut weights = Vec::new();
        path_weights(tile, &self.equation, parameters, &mut weights);
        weights
    }
}

impl Evaluator for ColumnsEvaluator {
    fn passes(&self) -> usize {
        1
    }

    fn with_pass(&self, _: &Arc<Hits>) -> Result<Arc<dyn Evaluator>, EvaluateError> {
        Err(EvaluateError::Backend("this backend makes pictures of one pass".to_owned()))
    }

    fn sum(&self, _: Range<usize>, parameters: &[f32], _: &AtomicBool) -> Option<Frame> {
        let mut frame = Frame::black(self.hits.view.width(), self.hits.view.height());
        let source = self.source(|_, light| self.is_on(parameters, light));
        let at_hits = self.at_hits(|body| self.equation.sum(Site::Hit, parameters, body));
        let pass = Pass {
            sources: vec![source],
            at_hits,
            at_misses: self.equation.sum(Site::Miss, parameters, 0),
            environment: self.equation.sum(Site::Environment, parameters, 0),
        };
        self.add(&pass, parameters, &|tile| self.weights(tile, parameters), &mut frame.linear);
        Some(frame)
    }

    fn draw(&self, parameters: &[f32], framebuffer: &mut Framebuffer) -> Drawn {
        Drawn::timed(|| framebuffer.set(&self.frame(parameters)))
    }

    fn drag(
        self: Arc<Self>,
        moved: &[usize],
        parameters: &[f32],
        budget: usize,
        _: Option<&DragBeginning>,
    ) -> Result<Box<dyn Drag>, EvaluateError> {
        let numbers = moved_parameters(&self.equation.layout, &self.parameters, moved);
        let moving: Vec<_> = numbers.into_iter().map(|(_, id, component)| (id, component)).collect();
        let slider = Arc::new(SliderPlan::new(&self.plan.bindings, &moving));
        let plan = DragPlan::new(&slider, None, &self.equation, &self.parameters, moved);
        let parameters = parameters.to_vec();
        Ok(Box::new(ColumnsDrag { evaluator: self, plan, parameters, images: None, is_ready: false, budget }))
    }

    fn bytes(&self) -> usize {
        let columns = self.tiles.iter().flatten().flat_map(|group| group.hits.iter().chain(group.records.iter().flatten()));
        self.hits.bytes() as usize + columns.map(|column| size_of_val(&**column)).sum::<usize>()
    }
}

/// The powers of kr and kt, the term, and the colours.
type Image = (Powers, usize, Vec<[f32; 3]>);

fn bytes_of<'i>(images: impl Iterator<Item = &'i Image>) -> usize {
    images.map(|(_, _, image)| size_of_val(&**image)).sum()
}

/// A drag: images of the whole picture for each power of kr and kt and each term. Term 0 is the fixed image.
struct ColumnsDrag {
    evaluator: Arc<ColumnsEvaluator>,
    plan: DragPlan,
    parameters: Vec<f32>,
    images: Option<Vec<Image>>,
    is_ready: bool,
    budget: usize,
}

/// Images with larger numbers may cancel each other and leave visible rounding errors.
const LARGEST: f32 = 256.0;

impl ColumnsDrag {
    fn source<'s>(
        &'s self,
        plan: &'s ContributionPlan,
        channels: Vec<usize>,
        active: Box<dyn Fn(usize, usize) -> bool + 's>,
    ) -> Source<'s> {
        Source { plan, graph: &self.plan.slider.separation.bindings.graph, channels, active, drag_columns: None }
    }

    /// Everything that does not move.
    fn fixed_pass(&self) -> Pass<'_> {
        let (evaluator, plan, parameters) = (&*self.evaluator, &self.plan, &self.parameters);
        let whole = evaluator.source(|body, light| evaluator.is_on(parameters, light) && !plan.moves_pair(body, light));
        let active = || Box::new(move |body, light| evaluator.is_on(parameters, light) && plan.moves_pair(body, light));
        let fixed = plan.slider.fixed.as_ref().map(|fixed| self.source(fixed, vec![0, 1, 2], active()));
        let at_hits = evaluator.at_hits(|body| plan.fixed(Site::Hit, parameters, body));
        Pass {
            sources: std::iter::once(whole).chain(fixed).collect(),
            at_hits,
            at_misses: plan.fixed(Site::Miss, parameters, 0),
            environment: plan.fixed(Site::Environment, parameters, 0),
        }
    }

    fn term_pass(&self, index: usize) -> Pass<'_> {
        let (evaluator, plan, parameters) = (&*self.evaluator, &self.plan, &self.parameters);
        let term = &plan.terms[index];
        let active = move |body: usize, light: usize| {
            (plan.moves_light_weight(light) || evaluator.is_on(parameters, light)) && plan.moves_pair(body, light)
        };
        let source = term.contribution.map(|contribution| {
            self.source(&plan.slider.moving[contribution], plan.moving_channels().components().collect(), Box::new(active))
        });
        let at_hits = evaluator.at_hits(|body| plan.image_colour(term, Site::Hit, parameters, body));
        Pass {
            sources: source.into_iter().collect(),
            at_hits,
            at_misses: plan.image_colour(term, Site::Miss, parameters, 0),
            environment: plan.image_colour(term, Site::Environment, parameters, 0),
        }
    }

    fn image(&self, pass: &Pass, powers: Powers) -> Vec<[f32; 3]> {
        let mut picture = vec![[0.0; 3]; self.evaluator.hits.view.pixels() as usize];
        let weights = |tile: &Tile| {
            let mut weights = Vec::new();
            let plan = &self.plan;
            PathMonomials::new(tile, &plan.equation, &self.parameters, plan.weights).of(powers, &mut weights);
            weights
        };
        self.evaluator.add(pass, &self.parameters, &weights, &mut picture);
        picture
    }

    /// The picture from images. `None` if it would not be accurate.
    fn picture(&self, parameters: &[f32]) -> Option<Vec<[f32; 3]>> {
        let (images, factors) = (self.images.as_ref()?, self.plan.factors(parameters));
        let mut sum = vec![[0.0; 3]; self.evaluator.hits.view.pixels() as usize];
        for (powers, image, colours) in images {
            let weight = factors.kr.powi(powers.reflections.into()) * factors.kt.powi(powers.refractions.into());
            let term = image.checked_sub(1).map_or([1.0; 3], |term| factors.terms[term]);
            let factor = term.map(|component| (weight * f64::from(component)) as f32);
            for (sum, colour) in sum.iter_mut().zip(colours) {
                for component in 0..3 {
                    let add = factor[component] * colour[component];
                    // NaN is not accurate either.
                    if !(colour[component].abs() <= LARGEST && add.abs() <= LARGEST) {
                        return None;
                    }
                    sum[component] += add;
                }
            }
        }
        if self.plan.method == Method::Specialised {
            self.add_live(parameters, &mut sum);
        }
        Some(sum)
    }

    fn add_live(&self, parameters: &[f32], picture: &mut [[f32; 3]]) {
        let (evaluator, plan) = (&*self.evaluator, &self.plan);
        let active = Box::new(|body, light| evaluator.is_on(parameters, light) && plan.moves_pair(body, light));
        let mut source = self.source(&plan.slider.moving[0], plan.moving_channels().components().collect(), active);
        source.drag_columns = plan.slider.columns.as_ref();
        let at_hits = evaluator.at_hits(|body| plan.moving(Site::Hit, parameters, body));
        let pass = Pass { sources: vec![source], at_hits, at_misses: [0.0; 3], environment: [0.0; 3] };
        evaluator.add(&pass, parameters, &|tile| evaluator.weights(tile, parameters), picture);
    }
}

impl Drag for ColumnsDrag {
    fn method(&self) -> Method {
        self.plan.method
    }

    fn frame(&mut self, parameters: &[f32], framebuffer: &mut Framebuffer) {
        if !self.plan.same_fixed(&self.parameters, parameters) {
            self.parameters = parameters.to_vec();
            (self.images, self.is_ready) = (None, false);
        }
        let view = self.evaluator.hits.view;
        let frame = |linear| Frame { width: view.width(), height: view.height(), linear };
        framebuffer.set(&self.picture(parameters).map_or_else(|| self.evaluator.frame(parameters), frame));
    }

    fn is_of_all_passes(&self) -> bool {
        true
    }

    fn prepare(&mut self) -> bool {
        if self.is_ready {
            return true;
        }
        let paths = |tile: &Tile| PathMonomials::new(tile, &self.plan.equation, &self.parameters, self.plan.weights).powers;
        let powers: BTreeSet<Powers> = self.evaluator.hits.tiles.iter().flat_map(paths).collect();
        let mut images = Vec::new();
        for powers in powers {
            images.push((powers, 0, self.image(&self.fixed_pass(), powers)));
            for term in 0..self.plan.terms.len() {
                images.push((powers, term + 1, self.image(&self.term_pass(term), powers)));
            }
        }
        let fits = self.plan.method != Method::General && bytes_of(images.iter()) <= self.budget;
        (self.images, self.is_ready) = (fits.then_some(images), true);
        true
    }

    fn is_ready(&self) -> bool {
        self.is_ready
    }

    fn bytes(&self) -> usize {
        bytes_of(self.images.iter().flatten())
    }

    fn pixels(&self) -> usize {
        self.evaluator.hits.view.pixels() as usize
    }
}
