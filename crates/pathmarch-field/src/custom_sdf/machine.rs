//! Interpreter of custom shapes, for eight points at once.
//!
//! All lanes run the same operations; a mask has the lanes that are active in a branch or a loop. A value has one slot for each
//! scalar, and a slot has eight lanes. WGSL has no recursion, so that every function has slots of its own and there is no stack.
//! Inactive lanes compute, too, but only active ones write to variables, to results and through pointers.
//!
//! Cost: about a nanosecond for an operation on a scalar and eight points.

use super::budget;
use super::math::{Function, Lanes};
use std::ops::Range;

/// A bit for each lane.
pub(super) type Mask = u8;

/// Compiled code of a custom shape.
pub(super) struct Program {
    /// Initial value of each slot.
    pub(super) memory: Vec<u32>,
    pub(super) functions: Vec<Procedure>,
    /// Index of the function `distance`.
    pub(super) entry: usize,
    /// First slots of the point and of the parameters.
    pub(super) point: u32,
    pub(super) params: u32,
    /// Slots of the variables outside functions, which are zero at the start of a call.
    pub(super) variables: Range<u32>,
}

/// Compiled function.
pub(super) struct Procedure {
    pub(super) body: Vec<Op>,
    /// First slot of its result, and the number of slots.
    pub(super) result: u32,
    pub(super) size: u32,
}

/// Operation; its operands are slots.
pub(super) enum Op {
    /// Applies a function to `count` scalars; an operand without its bit in `steps` is one scalar for all.
    Apply {
        function: Function,
        to: u32,
        operands: [u32; 3],
        steps: u8,
        count: u32,
    },
    /// Copies a value to slots that only this operation writes.
    Copy {
        to: u32,
        from: u32,
        count: u32,
    },
    /// Stores a value in a variable.
    Store {
        to: u32,
        from: u32,
        count: u32,
    },
    /// Computes the address `base` plus `index` times `stride`, with the index clamped below `limit`. If `relative`, `base` is a
    /// slot with the address.
    Address {
        to: u32,
        base: u32,
        relative: bool,
        index: u32,
        stride: u32,
        limit: u32,
    },
    /// Loads a value from a computed address.
    Load {
        to: u32,
        address: u32,
        count: u32,
    },
    /// Stores a value at a computed address.
    StoreAt {
        address: u32,
        from: u32,
        count: u32,
    },
    If {
        condition: u32,
        accept: Vec<Op>,
        reject: Vec<Op>,
    },
    Loop {
        body: Vec<Op>,
        continuing: Vec<Op>,
        break_if: Option<u32>,
        weight: u32,
    },
    /// Cases in order.
    Switch {
        selector: u32,
        cases: Vec<Case>,
    },
    Break,
    Continue,
    Return {
        value: Option<u32>,
    },
    /// Calls a function and copies its result to `to`.
    Call {
        function: usize,
        to: Option<u32>,
    },
}

/// Case of a switch.
pub(super) struct Case {
    /// Selector value; `None` is the default case.
    pub(super) value: Option<u32>,
    pub(super) body: Vec<Op>,
    pub(super) falls_through: bool,
}

/// Lanes that left the innermost loop or switch, and those that continue with its next pass.
#[derive(Default)]
struct Left {
    broke: Mask,
    continued: Mask,
}

/// Memory of a program, and the remaining loop budget of each lane.
pub(super) struct Machine {
    slots: Vec<Lanes>,
    budget: Lanes,
}

impl Machine {
    pub(super) fn new(program: &Program) -> Self {
        Self { slots: program.memory.iter().map(|&value| [value; 8]).collect(), budget: [0; 8] }
    }

    /// Evaluates the distance at eight points; only lanes in the mask are valid.
    pub(super) fn run(&mut self, program: &Program, point: [Lanes; 3], params: &[f32], mask: Mask) -> Lanes {
        self.slots[program.point as usize..][..3].copy_from_slice(&point);
        for (k, param) in params.iter().enumerate() {
            self.slots[program.params as usize + k] = [param.to_bits(); 8];
        }
        self.budget = [budget::LOOP_BUDGET; 8];
        self.slots[program.variables.start as usize..program.variables.end as usize].fill([0; 8]);
        self.call(program, program.entry, mask);
        self.slots[program.functions[program.entry].result as usize]
    }

    fn call(&mut self, program: &Program, function: usize, mask: Mask) {
        let procedure = &program.functions[function];
        self.slots[procedure.result as usize..][..procedure.size as usize].fill([0; 8]);
        self.block(program, procedure, &procedure.body, mask, &mut Left::default());
    }

    fn mask(&self, slot: u32) -> Mask {
        let lanes = &self.slots[slot as usize];
        (0..8).map(|lane| Mask::from(lanes[lane] != 0) << lane).sum()
    }

    fn copy(&mut self, to: u32, from: u32, count: u32) {
        self.slots.copy_within(from as usize..(from + count) as usize, to as usize);
    }

    fn store(&mut self, to: u32, from: u32, count: u32, active: Mask) {
        if active == Mask::MAX {
            return self.copy(to, from, count);
        }
        for k in 0..count {
            let value = self.slots[(from + k) as usize];
            let place = &mut self.slots[(to + k) as usize];
            for lane in 0..8 {
                if active >> lane & 1 == 1 {
                    place[lane] = value[lane];
                }
            }
        }
    }

    /// Runs a block. Returns the lanes that reach its end.
    fn block(
        &mut self,
        program: &Program,
        procedure: &Procedure,
        ops: &[Op],
        mut active: Mask,
        left: &mut Left,
    ) -> Mask {
        for op in ops {
            if active == 0 {
                break;
            }
            match op {
                Op::Apply { function, to, operands, steps, count } => {
                    self.apply(function, *to, operands, *steps, *count);
                }
                Op::Copy { to, from, count } => self.copy(*to, *from, *count),
                Op::Store { to, from, count } => self.store(*to, *from, *count, active),
                Op::Address { to, base, relative, index, stride, limit } => {
                    let index = self.slots[*index as usize];
                    let base = if *relative { self.slots[*base as usize] } else { [*base; 8] };
                    self.slots[*to as usize] =
                        std::array::from_fn(|lane| base[lane] + index[lane].min(limit - 1) * stride);
                }
                Op::Load { to, address, count } => {
                    let address = self.slots[*address as usize];
                    for k in 0..*count {
                        let value = std::array::from_fn(|lane| {
                            self.slots.get((address[lane] + k) as usize).map_or(0, |slot| slot[lane])
                        });
                        self.slots[(*to + k) as usize] = value;
                    }
                }
                Op::StoreAt { address, from, count } => {
                    let address = self.slots[*address as usize];
                    for k in 0..*count {
                        let value = self.slots[(*from + k) as usize];
                        for lane in (0..8).filter(|lane| active >> lane & 1 == 1) {
                            if let Some(slot) = self.slots.get_mut((address[lane] + k) as usize) {
                                slot[lane] = value[lane];
                            }
                        }
                    }
                }
                Op::If { condition, accept, reject } => {
                    let holds = self.mask(*condition);
                    let yes = self.block(program, procedure, accept, active & holds, left);
                    active = yes | self.block(program, procedure, reject, active & !holds, left);
                }
                Op::Loop { body, continuing, break_if, weight } => {
                    let mut running = active;
                    let mut ended = 0;
                    while running != 0 {
                        for lane in 0..8 {
                            let bit: Mask = 1 << lane;
                            if running & bit == 0 {
                                continue;
                            }
                            match self.budget[lane].checked_sub(*weight) {
                                Some(rest) => self.budget[lane] = rest,
                                None => {
                                    running &= !bit;
                                    ended |= bit;
                                }
                            }
                        }
                        let mut inner = Left::default();
                        running = self.block(program, procedure, body, running, &mut inner) | inner.continued;
                        let mut after = Left::default();
                        running = self.block(program, procedure, continuing, running, &mut after);
                        ended |= inner.broke;
                        if let Some(condition) = break_if {
                            let breaks = running & self.mask(*condition);
                            ended |= breaks;
                            running &= !breaks;
                        }
                    }
                    active = ended;
                }
                Op::Switch { selector, cases } => {
                    let selector = self.slots[*selector as usize];
                    let mut waiting = active;
                    let mut taken: Vec<Mask> = vec![0; cases.len()];
                    for (taken, case) in taken.iter_mut().zip(cases) {
                        if let Some(value) = case.value {
                            let equal: Mask = (0..8).map(|lane| Mask::from(selector[lane] == value) << lane).sum();
                            *taken = waiting & equal;
                            waiting &= !equal;
                        }
                    }
                    if let Some(default) = cases.iter().position(|case| case.value.is_none()) {
                        taken[default] = waiting;
                        waiting = 0;
                    }
                    let mut falling = 0;
                    active = waiting;
                    for (taken, case) in taken.into_iter().zip(cases) {
                        let mut inner = Left::default();
                        let through = self.block(program, procedure, &case.body, taken | falling, &mut inner);
                        left.continued |= inner.continued;
                        active |= inner.broke;
                        falling = if case.falls_through { through } else { 0 };
                        if !case.falls_through {
                            active |= through;
                        }
                    }
                    active |= falling;
                }
                Op::Break => {
                    left.broke |= active;
                    active = 0;
                }
                Op::Continue => {
                    left.continued |= active;
                    active = 0;
                }
                Op::Return { value } => {
                    if let Some(value) = value {
                        self.store(procedure.result, *value, procedure.size, active);
                    }
                    active = 0;
                }
                Op::Call { function, to } => {
                    self.call(program, *function, active);
                    if let Some(to) = to {
                        let called = &program.functions[*function];
                        self.copy(*to, called.result, called.size);
                    }
                }
            }
        }
        active
    }

    fn apply(&mut self, function: &Function, to: u32, operands: &[u32; 3], steps: u8, count: u32) {
        for k in 0..count {
            let slot = |n: usize| {
                let step = if steps >> n & 1 == 1 { k } else { 0 };
                &self.slots[(operands[n] + step) as usize]
            };
            let value = match function {
                Function::One(f) => f(slot(0)),
                Function::Two(f) => f(slot(0), slot(1)),
                Function::Three(f) => f(slot(0), slot(1), slot(2)),
            };
            self.slots[(to + k) as usize] = value;
        }
    }
}
