//! The declaration of a component's keys.

/// One key of a JSON object.
#[derive(Debug, Clone, Copy)]
pub struct Key {
    /// Name, Kratos's where Kratos has one.
    pub name: &'static str,
    /// Old names that mean the same; who uses one is told the present one, unless Kratos is repeated.
    pub aliases: &'static [&'static str],
    /// What values it takes.
    pub kind: Kind,
    /// What holds when it is not given.
    pub default: Default,
    /// Meaning, with its unit.
    pub help: &'static str,
    /// Whether a run that has failed may be resumed with another value: it says how steps are taken, not
    /// what the state means.
    pub adjustable: bool,
}

/// What a key takes.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// `true` or `false`.
    Bool,
    /// A whole number of at least `min`.
    Integer {
        /// Smallest value.
        min: i64,
    },
    /// A real number.
    Number(Range),
    /// A real number, or one of these texts.
    NumberOr(Range, &'static [&'static str]),
    /// A text.
    Text,
    /// One of these texts.
    Choice(&'static [&'static str]),
    /// Three real numbers.
    Vector3,
    /// `[start, end]`, where end may be "End".
    Interval,
    /// A number or a function of x, y, z, X, Y, Z, t as text.
    Function,
    /// Three of: number, function, null.
    Functions3,
    /// One or three booleans.
    Bools3,
    /// A list of texts.
    Texts,
    /// A list of anything.
    List,
    /// An object with declared keys.
    Object(&'static [Key]),
    /// Any value; whoever reads it checks it.
    Any,
}

/// The allowed range of a number.
#[derive(Debug, Clone, Copy)]
pub struct Range {
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
    /// Whether the lower bound itself is allowed.
    pub low_open: bool,
    /// How the range is named in messages.
    pub text: &'static str,
}

impl Range {
    /// Any finite number.
    pub const ANY: Range = Range { low: f64::NEG_INFINITY, high: f64::INFINITY, low_open: false, text: "a number" };
    /// Greater than zero.
    pub const POSITIVE: Range = Range { low: 0.0, high: f64::INFINITY, low_open: true, text: "a number above 0" };
    /// Zero or more.
    pub const NOT_NEGATIVE: Range =
        Range { low: 0.0, high: f64::INFINITY, low_open: false, text: "a number of at least 0" };
    /// Zero or less.
    pub const NOT_POSITIVE: Range =
        Range { low: f64::NEG_INFINITY, high: 0.0, low_open: false, text: "a number of at most 0" };
    /// From zero to one.
    pub const FRACTION: Range = Range { low: 0.0, high: 1.0, low_open: false, text: "a number from 0 to 1" };

    /// Whether the number is in the range.
    pub fn contains(&self, x: f64) -> bool {
        x.is_finite() && x <= self.high && if self.low_open { x > self.low } else { x >= self.low }
    }
}

/// The value of a key that is not given.
#[derive(Debug, Clone, Copy)]
pub enum Default {
    /// It must be given.
    Required,
    /// It stays away.
    Absent,
    /// This JSON text.
    Json(&'static str),
}

impl Key {
    /// A key that must be given.
    pub const fn required(name: &'static str, kind: Kind, help: &'static str) -> Key {
        Key { name, aliases: &[], kind, default: Default::Required, help, adjustable: false }
    }

    /// A key with a default, written as JSON text.
    pub const fn new(name: &'static str, kind: Kind, default: &'static str, help: &'static str) -> Key {
        Key { name, aliases: &[], kind, default: Default::Json(default), help, adjustable: false }
    }

    /// A key that may stay away.
    pub const fn optional(name: &'static str, kind: Kind, help: &'static str) -> Key {
        Key { name, aliases: &[], kind, default: Default::Absent, help, adjustable: false }
    }

    /// Two tables as one: the keys that several components share and those of one. `N` is `A + B`.
    pub const fn join<const A: usize, const B: usize, const N: usize>(shared: [Key; A], own: [Key; B]) -> [Key; N] {
        assert!(A + B == N, "the length of the joined table");
        let mut keys = [shared[0]; N];
        let mut i = 0;
        while i < N {
            keys[i] = if i < A { shared[i] } else { own[i - A] };
            i += 1;
        }
        keys
    }

    /// The same key under older names too.
    #[must_use]
    pub const fn or(mut self, aliases: &'static [&'static str]) -> Key {
        self.aliases = aliases;
        self
    }

    /// The same key, of which a failed run may be resumed with another value.
    #[must_use]
    pub const fn adjustable(mut self) -> Key {
        self.adjustable = true;
        self
    }

    /// True when `name` is this key's name or an older one.
    pub fn is(&self, name: &str) -> bool {
        self.name == name || self.aliases.contains(&name)
    }
}
