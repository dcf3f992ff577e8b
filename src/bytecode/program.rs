//! Programs of type II: the whole formula of a pixel, for its ray tree by equation (2) (thesis 4.2.3, 5.3.4).

use crate::bytecode::compile::{Code, FormulaCode};
use crate::bytecode::instruction::Instruction;
use crate::bytecode::machine::{self, MachineMemory};
use crate::formula::equation::{Colour, Equation, EquationTerm, Site, owner_index, weight_parameter};
use crate::lang::builtins::Operation;
use crate::lang::scalars::{Scalars, flush};
use crate::lang::surface_terms::SurfaceTerm;
use crate::lang::types::Type;
use crate::lang::variables::{Owner, Predefined, Variable};
use crate::scene::LightId;
use crate::trace::{Child, CoordinatesUse, HitVariables, LightVariables, NodeLight, RayNode, Tree, variable};
use crate::world::World;
use glam::DVec3;

/// The inputs of instantiation: a formula on a scene.
#[derive(Debug, Clone, Copy)]
pub struct Instantiation<'i> {
    /// The codes of the formula, of type I.
    pub code: &'i FormulaCode,
    /// The indices of parameter numbers.
    pub equation: Equation,
    /// The world.
    pub world: &'i World,
}

/// The largest size of the program of a pixel, in bytes: far more than any useful model and scene need.
pub const MAX_PROGRAM_BYTES: u64 = 1 << 30;

impl Instantiation<'_> {
    /// The variables of a hit.
    fn variables(&self, node: &RayNode) -> HitVariables {
        HitVariables::new(self.world, &node.hit, node.relative_index, CoordinatesUse::Read)
    }

    /// The bytes of the machine's memory for the program of any pixel, with rays of at most this depth.
    pub fn memory_bytes(&self, depth: u32) -> u64 {
        // At each depth, a sum waits for the weight and the colour of a child. Terms add a weight and factors.
        const LEVEL: u64 = 6;
        const TERMS: u64 = 10;
        let numbers = u64::from(depth) * LEVEL + TERMS + (self.code.depth() + self.code.slots()) as u64;
        numbers * size_of::<f32>() as u64
    }

    /// The size of the largest possible program of a pixel, in bytes: a full ray tree of this depth, and every light
    /// reaches every hit.
    pub fn largest(&self, depth: u32) -> u64 {
        // Bytes of references, weights and sums for an emitter, and for a hit.
        const EMITTER: u64 = 7;
        const HIT: u64 = 60;
        // A radiance and references, for both children.
        const ENVIRONMENT: u64 = 60;
        let hit = if self.world.environment().is_some() { HIT + ENVIRONMENT } else { HIT };
        let emitters = self.world.emitter_ids().count() as u64;
        let local = self.code.local.instance_bytes() as u64 + EMITTER;
        largest_tree(self.world, depth) * (emitters * local + self.code.surface_bytes() as u64 + hit)
    }
}

/// The number of hits in the largest possible ray tree of this depth.
pub fn largest_tree(world: &World, depth: u32) -> u64 {
    let bodies = || world.scene().bodies.iter();
    let (reflects, refracts) = (bodies().any(|body| !body.matte), bodies().any(|body| !body.opaque));
    match (reflects, refracts) {
        (false, false) => 1,
        (true, false) | (false, true) => u64::from(depth),
        (true, true) => (1 << depth) - 1,
    }
}

/// The program of one pixel, a part of [`Programs`].
#[derive(Debug, Clone, Copy)]
pub struct Program<'p> {
    /// The bytes of its instructions, all of type II.
    pub code: &'p [u8],
}

/// The programs of consecutive pixels, or of one pixel in consecutive passes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Programs {
    code: Vec<u8>,
    /// Where each pixel's program ends.
    ends: Vec<usize>,
    /// The deepest stack that any of them needs, in numbers.
    depth: usize,
    /// The slots that any of them needs. All instances of the formula use the same slots, one after the other.
    slots: usize,
}

impl Programs {
    /// No programs.
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends the program of a pixel.
    pub fn add(&mut self, instantiation: &Instantiation, tree: &Tree) {
        let mut assembler = BytecodeBuilder { instantiation, code: &mut self.code, height: 0, depth: self.depth };
        match tree.primary {
            Child::Hit(_) => assembler.tree(tree),
            Child::None => assembler.emit(Instruction::VectorValue([0.0; 3])),
            Child::Miss(direction) => assembler.miss(direction),
        }
        self.depth = assembler.depth;
        self.slots = self.slots.max(instantiation.code.slots());
        self.ends.push(self.code.len());
    }

    /// Removes all programs. Their memory is kept for others.
    pub fn clear(&mut self) {
        self.code.clear();
        self.ends.clear();
    }

    /// The number of programs.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The bytes of all programs.
    pub fn bytes(&self) -> usize {
        self.code.len()
    }

    /// The program of the pixel with this index. `None` where there is no such pixel.
    pub fn program(&self, index: usize) -> Option<Program<'_>> {
        let end = *self.ends.get(index)?;
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        Some(Program { code: &self.code[start..end] })
    }

    /// The memory for any of the programs. What `zero` is does not matter.
    pub fn memory<T: Copy>(&self, zero: T) -> MachineMemory<T> {
        MachineMemory::new(self.depth, self.slots, zero)
    }

    /// Runs the program of the pixel at this index and returns its red, green and blue. Without a program, it returns
    /// black. `parameters` holds the numbers of the layout. The memory comes from [`memory`](Self::memory).
    pub fn run<M>(&self, scalars: &mut M, index: usize, parameters: &[f32], memory: &mut MachineMemory<M::Value>) -> [M::Value; 3]
    where
        M: Scalars<Value: PartialEq>,
    {
        match self.program(index) {
            Some(program) => machine::run(scalars, program.code, parameters, memory),
            None => [scalars.constant(0.0); 3],
        }
    }
}

impl Program<'_> {
    /// The instructions in order.
    pub fn instructions(self) -> impl Iterator<Item = Instruction> {
        let mut rest = self.code;
        std::iter::from_fn(move || {
            let (instruction, bytes) = Instruction::decode(rest)?;
            rest = &rest[bytes..];
            Some(instruction)
        })
    }
}

/// Writes instructions and tracks the height of the stack.
struct BytecodeBuilder<'a> {
    instantiation: &'a Instantiation<'a>,
    code: &'a mut Vec<u8>,
    /// The number of numbers on the stack, and the maximum so far.
    height: usize,
    depth: usize,
}

impl BytecodeBuilder<'_> {
    fn emit(&mut self, instruction: Instruction) {
        let (takes, gives) = instruction.effect();
        self.height = self.height + gives - takes;
        self.depth = self.depth.max(self.height);
        instruction.encode(self.code);
    }

    /// A reference to a predefined parameter of the owner with index `owner`.
    fn parameter(&mut self, predefined: Predefined, owner: usize) {
        let index = self.instantiation.equation.index(predefined, owner) as u32;
        self.emit(match predefined.ty() {
            Type::Scalar | Type::Truth | Type::Texture => Instruction::ScalarReference(index),
            Type::Vector => Instruction::VectorReference(index),
        });
    }

    /// E(A) of the first node, which contains E of its children. Terms are added up in the order of equation (2).
    fn tree(&mut self, tree: &Tree) {
        enum BuildTask {
            Node(usize),
            /// A child of the node with this index, and the weight of its ray.
            Child(SurfaceTerm, Child, usize),
            /// Ends a guarded child. The operand of the guard is at this offset of the code.
            Close(SurfaceTerm, usize),
        }
        let mut tasks = vec![BuildTask::Node(0)];
        while let Some(task) = tasks.pop() {
            match task {
                BuildTask::Node(index) => {
                    let node = &tree.nodes[index];
                    self.local(node);
                    tasks.push(BuildTask::Child(SurfaceTerm::Refracted, node.refracted, index));
                    tasks.push(BuildTask::Child(SurfaceTerm::Reflected, node.reflected, index));
                }
                BuildTask::Child(_, Child::None, _) => {}
                BuildTask::Child(weight, Child::Miss(direction), parent) => {
                    self.weight(weight, &tree.nodes[parent]);
                    self.miss(direction);
                    self.weigh(weight);
                    self.emit(Instruction::Operation(Operation::AddVV));
                }
                BuildTask::Child(weight, Child::Hit(index), parent) => {
                    self.weight(weight, &tree.nodes[parent]);
                    let is_given = self.instantiation.code.surface(weight).is_some();
                    self.emit(if is_given { Instruction::GuardVector(0) } else { Instruction::Guard(0) });
                    tasks.push(BuildTask::Close(weight, self.code.len() - size_of::<u32>()));
                    tasks.push(BuildTask::Node(index));
                }
                BuildTask::Close(weight, operand) => {
                    self.weigh(weight);
                    let guarded = operand + size_of::<u32>();
                    // No program is larger than `MAX_PROGRAM_BYTES`, see `largest`.
                    let length = (self.code.len() - guarded) as u32;
                    self.code[operand..guarded].copy_from_slice(&length.to_le_bytes());
                    self.emit(Instruction::Operation(Operation::AddVV));
                }
            }
        }
    }

    /// The weight of a child ray of a node: three numbers if the formula gives it, else one.
    fn weight(&mut self, weight: SurfaceTerm, node: &RayNode) {
        if let Some(code) = self.instantiation.code.surface(weight) {
            let hit = self.instantiation.variables(node);
            self.instance(code, node, None, &|symbol| hit.value(symbol).unwrap_or_default());
        } else if let Some(parameter) = weight_parameter(weight) {
            self.parameter(parameter, node.hit.body.index());
        }
    }

    /// Multiplies a weight and a colour.
    fn weigh(&mut self, weight: SurfaceTerm) {
        let is_given = self.instantiation.code.surface(weight).is_some();
        self.emit(if is_given { Instruction::WeighVector } else { Instruction::Weigh });
    }

    /// The contributions of the lights at a hit, and the terms without lights.
    fn local(&mut self, node: &RayNode) {
        let world = self.instantiation.world;
        let hit = self.instantiation.variables(node);
        let mut count = 0;
        for NodeLight { emitter, visible } in &node.lights {
            let light = world.light_of(*emitter);
            let record = LightVariables::new(&node.hit, &world.emitter(*emitter).sample(&node.hit, &node.key), *visible);
            for term in EquationTerm::at(Site::LitRecord) {
                let code = &self.instantiation.code.local;
                let formula = |assembler: &mut Self| {
                    assembler.instance(code, node, Some(light), &|symbol| variable(symbol, &hit, &record));
                };
                self.term(term, node.hit.body.index(), light.index(), &mut count, formula);
            }
        }
        let equation = self.instantiation.equation;
        for term in EquationTerm::at(Site::Hit).filter(|term| equation.has(term)) {
            self.term(term, node.hit.body.index(), 0, &mut count, |_| {});
        }
        for term in SurfaceTerm::ALL.iter().filter(|term| !term.is_weight()) {
            let Some(code) = self.instantiation.code.surface(*term) else { continue };
            self.instance(code, node, None, &|symbol| hit.value(symbol).unwrap_or_default());
            if count > 0 {
                self.emit(Instruction::Operation(Operation::AddVV));
            }
            count += 1;
        }
    }

    /// The terms of a ray that leaves the scene.
    fn miss(&mut self, direction: DVec3) {
        let mut count = 0;
        for term in EquationTerm::at(Site::Miss) {
            self.term(term, 0, 0, &mut count, |_| {});
        }
        let Some(environment) = self.instantiation.world.environment() else { return };
        for term in EquationTerm::at(Site::Environment) {
            self.term(term, 0, environment.light().index(), &mut count, |assembler| {
                assembler.emit(Instruction::VectorValue(environment.radiance(direction).map(flush)));
                assembler.emit(Instruction::Operation(Operation::MulVV));
            });
        }
    }

    /// A term of equation (2), added to the `count` terms before it. `rest` writes the formula, or what the other
    /// colours are multiplied by.
    fn term(&mut self, term: &EquationTerm, body: usize, light: usize, count: &mut usize, rest: impl FnOnce(&mut Self)) {
        if let Some(weight) = term.weight {
            self.parameter(weight, owner_index(weight, body, light));
        }
        match term.colour {
            Colour::Formula => rest(self),
            Colour::Parameters(factors) => {
                for (number, factor) in factors.iter().enumerate() {
                    self.parameter(*factor, owner_index(*factor, body, light));
                    if number > 0 {
                        self.emit(Instruction::Operation(Operation::MulVV));
                    }
                }
                rest(self);
            }
        }
        if term.weight.is_some() {
            self.emit(Instruction::Weigh);
        }
        if *count > 0 {
            self.emit(Instruction::Operation(Operation::AddVV));
        }
        *count += 1;
    }

    /// Code with numbers for variables and references for parameters: type I into type II. What is evaluated once at a
    /// hit has no light, and reads nothing of one.
    fn instance(&mut self, code: &Code, node: &RayNode, light: Option<LightId>, value: &dyn Fn(Variable) -> [f32; 3]) {
        let equation = self.instantiation.equation;
        for instruction in code.instructions() {
            let instance = match *instruction {
                Instruction::Variable(symbol) => {
                    let value = value(symbol).map(flush);
                    match symbol.ty() {
                        Type::Scalar | Type::Truth | Type::Texture => Instruction::ScalarValue(value[0]),
                        Type::Vector => Instruction::VectorValue(value),
                    }
                }
                Instruction::Parameter(owner, ty, slot) => {
                    let owner_index = match owner {
                        Owner::Global => 0,
                        Owner::Body => node.hit.body.index(),
                        Owner::Light => light.map_or(0, LightId::index),
                    };
                    let index = (equation.layout.row(owner, owner_index) + slot as usize) as u32;
                    match ty {
                        Type::Scalar | Type::Truth | Type::Texture => Instruction::ScalarReference(index),
                        Type::Vector => Instruction::VectorReference(index),
                    }
                }
                same @ (Instruction::ScalarValue(_)
                | Instruction::VectorValue(_)
                | Instruction::ScalarReference(_)
                | Instruction::VectorReference(_)
                | Instruction::Weigh
                | Instruction::Guard(_)
                | Instruction::WeighVector
                | Instruction::GuardVector(_)
                | Instruction::Operation(_)
                | Instruction::ByComponents(..)
                | Instruction::Store(..)
                | Instruction::Load(..)) => same,
            };
            self.emit(instance);
        }
    }
}
