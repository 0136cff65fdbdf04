//! Functions of place and time, written in Python's syntax as users write them in JSON.
//!
//! `sin(2*pi*t)`, `x**2 if t < 1 else 0.0`. A text is parsed once into a flat program for a stack
//! machine; evaluation neither recurses nor allocates. All numbers are doubles, with the rules of
//! Python 3: `/` divides truly, `//` and `%` round down, `**` binds stronger than a sign to its
//! left and groups to the right, comparisons chain, `and` and `or` give one of their operands and
//! do not look at the second without need, and of `a if c else b` only one branch is evaluated.
//!
//! An operation at which Python would stop with an error (`1/0`, `sqrt(-1)`, `exp(1000)`) gives NaN
//! or an infinite number; whoever uses a result checks that it is finite.

mod functions;
mod parser;
mod tokens;

#[cfg(test)]
mod tests;

use std::fmt;

/// Places on the stack of the machine; the parser refuses what needs more.
const STACK: usize = 32;

/// Where and when an expression is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Arguments {
    /// Current coordinate, in metres.
    pub x: f64,
    /// Current coordinate, in metres.
    pub y: f64,
    /// Current coordinate, in metres.
    pub z: f64,
    /// Initial coordinates `X`, `Y`, `Z`, in metres.
    pub initial: [f64; 3],
    /// Time, in seconds.
    pub t: f64,
}

/// The names that stand for arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Variable {
    Current(u8),
    Initial(u8),
    Time,
}

/// `<`, `<=`, `>`, `>=`, `==` and `!=`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Relation {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

impl Relation {
    fn holds(self, a: f64, b: f64) -> bool {
        match self {
            Relation::Less => a < b,
            Relation::LessEqual => a <= b,
            Relation::Greater => a > b,
            Relation::GreaterEqual => a >= b,
            Relation::Equal => a == b,
            Relation::NotEqual => a != b,
        }
    }
}

/// An instruction of the stack machine. Jumps count instructions beyond the next one.
#[derive(Debug, Clone, Copy)]
enum Instruction {
    Push(f64),
    Load(Variable),
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Call1(fn(f64) -> f64),
    Call2(fn(f64, f64) -> f64),
    Compare(Relation),
    /// A comparison that another one follows: leaves the right operand and goes on when it holds,
    /// else leaves 0 and jumps.
    Chain(Relation, usize),
    /// Jumps if the top is false and keeps it, else drops it.
    And(usize),
    /// Jumps if the top is true and keeps it, else drops it.
    Or(usize),
    /// Drops the top and jumps if it was false.
    JumpUnless(usize),
    Jump(usize),
}

/// A parsed function of place and time.
#[derive(Debug, Clone)]
pub struct Expression {
    text: String,
    program: Vec<Instruction>,
}

impl Expression {
    /// Parses a text in Python's syntax.
    ///
    /// Names: `x y z` (current place), `X Y Z` (initial place), `t`, `pi`, `e`, `tau`, `True`,
    /// `False`, and the functions of Python's `math` with one or two arguments together with
    /// `abs`, `min`, `max`, `pow` and `round`, also behind `math.`, `np.` or `numpy.`.
    ///
    /// # Errors
    /// Where the text leaves the syntax, and what is allowed there.
    ///
    /// ```
    /// use bia_kernel::expression::{Arguments, Expression};
    /// let load = Expression::parse("2.0 * t if t < 0.5 else 1.0")?;
    /// assert_eq!(load.evaluate(&Arguments { t: 0.25, ..Arguments::default() }), 0.5);
    /// assert!(load.depends_on_time() && !load.depends_on_space());
    /// # Ok::<(), bia_kernel::expression::ExpressionError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        Ok(Self { text: text.to_string(), program: parser::parse(text)? })
    }

    /// The function that has the same value everywhere and always.
    pub fn constant(value: f64) -> Self {
        Self { text: format!("{value:?}"), program: vec![Instruction::Push(value)] }
    }

    /// The value for these arguments; NaN or infinite after an operation that has no value.
    pub fn evaluate(&self, arguments: &Arguments) -> f64 {
        run(&self.program, arguments)
    }

    /// True when the time `t` occurs.
    pub fn depends_on_time(&self) -> bool {
        self.program.iter().any(|instruction| matches!(instruction, Instruction::Load(Variable::Time)))
    }

    /// True when a coordinate occurs, current or initial.
    pub fn depends_on_space(&self) -> bool {
        let is_coordinate = |variable: &Variable| *variable != Variable::Time;
        self.program.iter().any(|i| matches!(i, Instruction::Load(variable) if is_coordinate(variable)))
    }

    /// The value, when no argument occurs.
    pub fn as_constant(&self) -> Option<f64> {
        match self.program.as_slice() {
            [Instruction::Push(value)] => Some(*value),
            _ => None,
        }
    }
}

impl PartialEq for Expression {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Runs a program of the parser, which has made sure that it fits the stack.
fn run(program: &[Instruction], arguments: &Arguments) -> f64 {
    let mut stack = [0.0; STACK];
    // `top` is the place above the topmost value.
    let (mut top, mut next) = (0, 0);
    while let Some(instruction) = program.get(next) {
        next += 1;
        match *instruction {
            Instruction::Push(value) => {
                stack[top] = value;
                top += 1;
            }
            Instruction::Load(variable) => {
                stack[top] = argument(arguments, variable);
                top += 1;
            }
            Instruction::Call1(function) => stack[top - 1] = function(stack[top - 1]),
            Instruction::And(jump) if stack[top - 1] == 0.0 => next += jump,
            Instruction::Or(jump) if stack[top - 1] != 0.0 => next += jump,
            Instruction::And(_) | Instruction::Or(_) => top -= 1,
            Instruction::Jump(jump) => next += jump,
            Instruction::JumpUnless(jump) => {
                top -= 1;
                next += if stack[top] == 0.0 { jump } else { 0 };
            }
            Instruction::Chain(relation, jump) => {
                top -= 1;
                let holds = relation.holds(stack[top - 1], stack[top]);
                stack[top - 1] = if holds { stack[top] } else { 0.0 };
                next += if holds { 0 } else { jump };
            }
            two_operands => {
                top -= 1;
                stack[top - 1] = combine(two_operands, stack[top - 1], stack[top]);
            }
        }
    }
    stack[0]
}

#[inline]
fn combine(instruction: Instruction, a: f64, b: f64) -> f64 {
    match instruction {
        Instruction::Add => a + b,
        Instruction::Subtract => a - b,
        Instruction::Multiply => a * b,
        // Python has no quotient by zero.
        Instruction::Divide if b == 0.0 => f64::NAN,
        Instruction::Divide => a / b,
        Instruction::Power => a.powf(b),
        Instruction::Call2(function) => function(a, b),
        Instruction::Compare(relation) => f64::from(relation.holds(a, b)),
        // The other instructions never come here.
        _ => f64::NAN,
    }
}

fn argument(arguments: &Arguments, variable: Variable) -> f64 {
    match variable {
        Variable::Current(0) => arguments.x,
        Variable::Current(1) => arguments.y,
        Variable::Current(_) => arguments.z,
        Variable::Initial(axis) => arguments.initial[usize::from(axis)],
        Variable::Time => arguments.t,
    }
}

/// A text that is no expression: where, and why.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{fault} (at character {position} of {excerpt:?})")]
pub struct ExpressionError {
    /// Position of the fault in the text, in characters from 1.
    pub position: usize,
    /// The text, or what stands around the fault when it is long.
    pub excerpt: String,
    /// What is wrong.
    pub fault: ExpressionFault,
}

/// What is wrong with an expression.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ExpressionFault {
    /// A character that no expression has.
    #[error("the character {0:?} has no meaning here{hint}", hint = tokens::hint(*.0))]
    Character(char),
    /// Something else where a value must stand.
    #[error("{0} stands where a number, a name, `(`, a sign or `not` is expected")]
    NoOperand(String),
    /// Something else behind a value.
    #[error("{found} stands where {expected} is expected")]
    Unexpected {
        /// What was found.
        found: String,
        /// What is allowed there.
        expected: &'static str,
    },
    /// A name that means nothing.
    #[error("the name {name:?} is unknown{}; {list}", nearest.map(|n| format!(", did you mean {n:?}?")).unwrap_or_default())]
    UnknownName {
        /// The name.
        name: String,
        /// The nearest known one.
        nearest: Option<&'static str>,
        /// All known ones.
        list: String,
    },
    /// A function without its parentheses.
    #[error("the function {0} needs its arguments in parentheses")]
    NotCalled(String),
    /// A wrong number of arguments.
    #[error("{name} takes {allowed}, not {found}")]
    Arguments {
        /// The function.
        name: String,
        /// The numbers of arguments it takes.
        allowed: &'static str,
        /// The number that was given.
        found: usize,
    },
    /// A number beyond the range of a double.
    #[error("the number {0} is beyond the range of a double (about 1.8e308)")]
    Range(String),
    /// Too many parentheses, signs, powers or branches inside each other.
    #[error("the expression is nested too deeply")]
    TooDeep,
    /// A text of more than 65,536 bytes.
    #[error("the expression is longer than 65536 bytes")]
    TooLong,
}
