//! The functions that expressions may call, with the meaning they have in Python.

use super::Instruction;

/// How a function is called.
#[derive(Debug, Clone, Copy)]
pub(super) enum Function {
    One(fn(f64) -> f64),
    Two(fn(f64, f64) -> f64),
    /// `log(x)` or `log(x, base)`.
    OneOrTwo(fn(f64) -> f64, fn(f64, f64) -> f64),
    /// Two or more arguments, taken from the left.
    Many(fn(f64, f64) -> f64),
}

impl Function {
    /// The instruction for this number of arguments; it stands `count - 1` times for `Many`.
    pub fn instruction(self, count: usize) -> Option<Instruction> {
        match (self, count) {
            (Function::One(f) | Function::OneOrTwo(f, _), 1) => Some(Instruction::Call1(f)),
            (Function::Two(f) | Function::OneOrTwo(_, f), 2) => Some(Instruction::Call2(f)),
            (Function::Many(f), 2..) => Some(Instruction::Call2(f)),
            _ => None,
        }
    }

    /// The numbers of arguments, in words.
    pub fn allowed(self) -> &'static str {
        match self {
            Function::One(_) => "1 argument",
            Function::Two(_) => "2 arguments",
            Function::OneOrTwo(..) => "1 or 2 arguments",
            Function::Many(_) => "2 or more arguments",
        }
    }
}

/// All functions by name.
pub(super) const FUNCTIONS: [(&str, Function); 34] = [
    ("abs", Function::One(f64::abs)),
    ("acos", Function::One(f64::acos)),
    ("acosh", Function::One(f64::acosh)),
    ("asin", Function::One(f64::asin)),
    ("asinh", Function::One(f64::asinh)),
    ("atan", Function::One(f64::atan)),
    ("atan2", Function::Two(f64::atan2)),
    ("atanh", Function::One(f64::atanh)),
    ("ceil", Function::One(f64::ceil)),
    ("copysign", Function::Two(f64::copysign)),
    ("cos", Function::One(f64::cos)),
    ("cosh", Function::One(f64::cosh)),
    ("degrees", Function::One(|x| x * (180.0 / std::f64::consts::PI))),
    ("exp", Function::One(f64::exp)),
    ("expm1", Function::One(f64::exp_m1)),
    ("fabs", Function::One(f64::abs)),
    ("floor", Function::One(f64::floor)),
    ("fmod", Function::Two(|x, y| x % y)),
    ("hypot", Function::Two(f64::hypot)),
    // Python divides the natural logarithms.
    ("log", Function::OneOrTwo(f64::ln, |x, base| x.ln() / base.ln())),
    ("log10", Function::One(f64::log10)),
    ("log1p", Function::One(f64::ln_1p)),
    ("log2", Function::One(f64::log2)),
    ("max", Function::Many(|a, b| if b > a || b.is_nan() { b } else { a })),
    ("min", Function::Many(|a, b| if b < a || b.is_nan() { b } else { a })),
    ("pow", Function::Two(f64::powf)),
    ("radians", Function::One(|x| x * (std::f64::consts::PI / 180.0))),
    ("round", Function::One(f64::round_ties_even)),
    ("sin", Function::One(f64::sin)),
    ("sinh", Function::One(f64::sinh)),
    ("sqrt", Function::One(f64::sqrt)),
    ("tan", Function::One(f64::tan)),
    ("tanh", Function::One(f64::tanh)),
    ("trunc", Function::One(f64::trunc)),
];

/// `a % b`: has the sign of `b`.
pub(super) fn modulo(a: f64, b: f64) -> f64 {
    let rest = a % b;
    if rest == 0.0 {
        return f64::copysign(0.0, b);
    }
    if (rest < 0.0) == (b < 0.0) { rest } else { rest + b }
}

/// `a // b`: rounded down, consistent with `%` also where `a / b` rounds to a whole number.
pub(super) fn floor_divide(a: f64, b: f64) -> f64 {
    if b == 0.0 {
        return f64::NAN;
    }
    let rest = a % b;
    let whole = (a - rest) / b - if rest != 0.0 && (rest < 0.0) != (b < 0.0) { 1.0 } else { 0.0 };
    whole.round()
}

pub(super) fn negate(a: f64) -> f64 {
    -a
}

pub(super) fn not(a: f64) -> f64 {
    f64::from(a == 0.0)
}
