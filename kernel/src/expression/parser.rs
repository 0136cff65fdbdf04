//! From text to program: a parser by binding strength (V. Pratt, "Top down operator precedence",
//! POPL 1973).

use super::functions::{FUNCTIONS, Function, floor_divide, modulo, negate, not};
use super::tokens::{Token, Tokens};
use super::{Arguments, ExpressionError, ExpressionFault, Instruction, Relation, STACK, Variable, run};
use crate::diagnostic::nearest;

/// The longest text, in bytes.
const LONGEST: usize = 1 << 16;

/// How deep the parser may call itself.
const DEEPEST: usize = 200;

/// Binding strengths; an operator is taken if it binds at least as strongly as is asked for.
mod strength {
    pub const CHOICE: u8 = 0;
    pub const OR: u8 = 1;
    pub const AND: u8 = 2;
    pub const NOT: u8 = 3;
    pub const COMPARE: u8 = 4;
    pub const SUM: u8 = 5;
    pub const PRODUCT: u8 = 6;
    pub const SIGN: u8 = 7;
    pub const POWER: u8 = 8;
}

const VARIABLES: [(&str, Variable); 7] = [
    ("x", Variable::Current(0)),
    ("y", Variable::Current(1)),
    ("z", Variable::Current(2)),
    ("X", Variable::Initial(0)),
    ("Y", Variable::Initial(1)),
    ("Z", Variable::Initial(2)),
    ("t", Variable::Time),
];

const CONSTANTS: [(&str, f64); 5] = [
    ("pi", std::f64::consts::PI),
    ("e", std::f64::consts::E),
    ("tau", std::f64::consts::TAU),
    ("True", 1.0),
    ("False", 0.0),
];

type Parsed<T> = Result<T, ExpressionError>;

pub(super) fn parse(text: &str) -> Parsed<Vec<Instruction>> {
    if text.len() > LONGEST {
        let excerpt = text.chars().take(40).collect();
        return Err(ExpressionError { position: 1, excerpt, fault: ExpressionFault::TooLong });
    }
    let mut parser = Parser { tokens: Tokens::new(text)?, program: Vec::new(), stack: 0, depth: 0 };
    parser.expression(strength::CHOICE)?;
    if parser.tokens.token != Token::End {
        return Err(parser.unexpected("an operator or the end of the text"));
    }
    Ok(parser.program)
}

struct Parser<'a> {
    tokens: Tokens<'a>,
    program: Vec<Instruction>,
    /// Values on the machine's stack at this point of the program.
    stack: usize,
    /// Calls of [`Parser::expression`] inside each other.
    depth: usize,
}

/// True for a part of the program without arguments.
type Constant = bool;

impl Parser<'_> {
    /// Parses operators that bind at least as strongly as `least`; adds one value to the stack.
    fn expression(&mut self, least: u8) -> Parsed<Constant> {
        if self.depth == DEEPEST {
            return Err(self.tokens.error(ExpressionFault::TooDeep));
        }
        self.depth += 1;
        let start = self.program.len();
        let mut constant = self.operand(least)?;
        while let Some(found) = self.operator().filter(|&found| found >= least) {
            constant &= match found {
                strength::CHOICE => self.choice(start)?,
                strength::OR | strength::AND => self.lazy(found)?,
                strength::COMPARE => self.comparison()?,
                _ => self.arithmetic(found)?,
            };
            self.fold(start, constant);
        }
        self.depth -= 1;
        Ok(constant)
    }

    /// Binding strength of the operator under the cursor, if there is one.
    fn operator(&self) -> Option<u8> {
        Some(match self.tokens.token {
            Token::Name("if") => strength::CHOICE,
            Token::Name("or") => strength::OR,
            Token::Name("and") => strength::AND,
            Token::Symbol("<" | "<=" | ">" | ">=" | "==" | "!=") => strength::COMPARE,
            Token::Symbol("+" | "-") => strength::SUM,
            Token::Symbol("*" | "/" | "//" | "%") => strength::PRODUCT,
            Token::Symbol("**") => strength::POWER,
            _ => return None,
        })
    }

    /// Replaces a part of the program without arguments by its value.
    fn fold(&mut self, start: usize, constant: Constant) {
        if constant {
            let value = run(&self.program[start..], &Arguments::default());
            self.program.truncate(start);
            self.program.push(Instruction::Push(value));
        }
    }

    /// Adds an instruction that pushes a value.
    fn push(&mut self, instruction: Instruction) -> Parsed<()> {
        if self.stack == STACK {
            return Err(self.tokens.error(ExpressionFault::TooDeep));
        }
        self.stack += 1;
        self.program.push(instruction);
        Ok(())
    }

    /// Adds an instruction that takes its operands from the stack and leaves one value.
    fn apply(&mut self, instruction: Instruction) {
        if !matches!(instruction, Instruction::Call1(_)) {
            self.stack -= 1;
        }
        self.program.push(instruction);
    }

    fn unexpected(&self, expected: &'static str) -> ExpressionError {
        self.tokens.error(ExpressionFault::Unexpected { found: self.tokens.shown(), expected })
    }

    fn expect(&mut self, token: Token<'static>, expected: &'static str) -> Parsed<()> {
        if self.tokens.token != token {
            return Err(self.unexpected(expected));
        }
        self.tokens.advance()
    }

    /// A number, a name, a call, parentheses, or a sign or `not` with its operand.
    fn operand(&mut self, least: u8) -> Parsed<Constant> {
        let (token, start, byte) = (self.tokens.token, self.program.len(), self.tokens.start);
        let prefix = match token {
            Token::Symbol("-") => Some((Some(negate as fn(f64) -> f64), strength::SIGN)),
            Token::Symbol("+") => Some((None, strength::SIGN)),
            Token::Name("not") if least <= strength::NOT => Some((Some(not as fn(f64) -> f64), strength::NOT)),
            Token::Name("if" | "else" | "and" | "or" | "not") | Token::End => None,
            Token::Number(value) => {
                self.tokens.advance()?;
                return self.push(Instruction::Push(value)).map(|()| true);
            }
            Token::Name(name) => {
                self.tokens.advance()?;
                return self.name(name, byte);
            }
            Token::Symbol("(") => {
                self.tokens.advance()?;
                let constant = self.expression(strength::CHOICE)?;
                self.expect(Token::Symbol(")"), "an operator or `)`")?;
                return Ok(constant);
            }
            Token::Symbol(_) => None,
        };
        let Some((function, strength)) = prefix else {
            return Err(self.tokens.error(ExpressionFault::NoOperand(self.tokens.shown())));
        };
        self.tokens.advance()?;
        let constant = self.expression(strength)?;
        self.program.extend(function.map(Instruction::Call1));
        self.fold(start, constant);
        Ok(constant)
    }

    /// A variable, a constant or a call; `byte` is where the name stands.
    fn name(&mut self, full: &str, byte: usize) -> Parsed<Constant> {
        let module = ["math.", "np.", "numpy."].iter().find_map(|module| full.strip_prefix(module));
        let name = module.unwrap_or(full);
        if let Some((_, value)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            return self.push(Instruction::Push(*value)).map(|()| true);
        }
        let variable = VARIABLES.iter().find(|(known, _)| *known == name && module.is_none());
        if let Some((_, variable)) = variable {
            return self.push(Instruction::Load(*variable)).map(|()| false);
        }
        let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            return Err(self.tokens.error_at(byte, unknown(full, name)));
        };
        if self.tokens.token != Token::Symbol("(") {
            return Err(self.tokens.error_at(byte, ExpressionFault::NotCalled(name.to_string())));
        }
        self.call(name, *function, byte)
    }

    fn call(&mut self, name: &str, function: Function, byte: usize) -> Parsed<Constant> {
        self.tokens.advance()?;
        let (start, mut constant, mut count) = (self.program.len(), true, 0);
        let many = matches!(function, Function::Many(_));
        while self.tokens.token != Token::Symbol(")") {
            constant &= self.expression(strength::CHOICE)?;
            count += 1;
            // Each further argument is combined at once, so that their number needs no stack.
            if let (true, Some(instruction)) = (many, function.instruction(count)) {
                self.apply(instruction);
            }
            match self.tokens.token {
                Token::Symbol(",") => self.tokens.advance()?,
                Token::Symbol(")") => {}
                _ => return Err(self.unexpected("an operator, `,` or `)`")),
            }
        }
        self.tokens.advance()?;
        let Some(instruction) = function.instruction(count) else {
            let fault =
                ExpressionFault::Arguments { name: name.to_string(), allowed: function.allowed(), found: count };
            return Err(self.tokens.error_at(byte, fault));
        };
        if !many {
            self.apply(instruction);
        }
        self.fold(start, constant);
        Ok(constant)
    }

    /// `a + b` and its like.
    fn arithmetic(&mut self, found: u8) -> Parsed<Constant> {
        let instruction = match self.tokens.token {
            Token::Symbol("+") => Instruction::Add,
            Token::Symbol("-") => Instruction::Subtract,
            Token::Symbol("*") => Instruction::Multiply,
            Token::Symbol("/") => Instruction::Divide,
            Token::Symbol("//") => Instruction::Call2(floor_divide),
            Token::Symbol("%") => Instruction::Call2(modulo),
            _ => Instruction::Power,
        };
        self.tokens.advance()?;
        // A power groups to the right and takes a sign at its right.
        let constant = self.expression(if found == strength::POWER { strength::SIGN } else { found + 1 })?;
        self.apply(instruction);
        Ok(constant)
    }

    fn relation(&self) -> Option<Relation> {
        Some(match self.tokens.token {
            Token::Symbol("<") => Relation::Less,
            Token::Symbol("<=") => Relation::LessEqual,
            Token::Symbol(">") => Relation::Greater,
            Token::Symbol(">=") => Relation::GreaterEqual,
            Token::Symbol("==") => Relation::Equal,
            Token::Symbol("!=") => Relation::NotEqual,
            _ => return None,
        })
    }

    /// `a < b <= c …`: each operand is evaluated once, and no further than needed.
    fn comparison(&mut self) -> Parsed<Constant> {
        let (mut constant, mut chains) = (true, Vec::new());
        while let Some(relation) = self.relation() {
            self.tokens.advance()?;
            constant &= self.expression(strength::COMPARE + 1)?;
            self.stack -= 1;
            if self.relation().is_none() {
                self.program.push(Instruction::Compare(relation));
                break;
            }
            chains.push((self.program.len(), relation));
            self.program.push(Instruction::Chain(relation, 0));
        }
        let end = self.program.len();
        for (at, relation) in chains {
            self.program[at] = Instruction::Chain(relation, end - at - 1);
        }
        Ok(constant)
    }

    /// `a and b`, `a or b`.
    fn lazy(&mut self, found: u8) -> Parsed<Constant> {
        let at = self.program.len();
        self.program.push(Instruction::Jump(0));
        self.tokens.advance()?;
        self.stack -= 1;
        let constant = self.expression(found + 1)?;
        let jump = self.program.len() - at - 1;
        self.program[at] = if found == strength::OR { Instruction::Or(jump) } else { Instruction::And(jump) };
        Ok(constant)
    }

    /// `a if c else b`, of which `a` stands in the program from `start` on: it moves behind `c`.
    fn choice(&mut self, start: usize) -> Parsed<Constant> {
        let first = self.program.split_off(start);
        self.tokens.advance()?;
        self.stack -= 1;
        let condition = self.expression(strength::OR)?;
        self.expect(Token::Name("else"), "an operator or `else`")?;
        self.program.push(Instruction::JumpUnless(first.len() + 1));
        self.program.extend(first);
        let at = self.program.len();
        self.program.push(Instruction::Jump(0));
        self.stack -= 1;
        let second = self.expression(strength::CHOICE)?;
        self.program[at] = Instruction::Jump(self.program.len() - at - 1);
        Ok(condition && second)
    }
}

fn unknown(full: &str, name: &str) -> ExpressionFault {
    let variables = VARIABLES.iter().map(|(name, _)| *name);
    let constants = CONSTANTS.iter().map(|(name, _)| *name);
    let functions = FUNCTIONS.iter().map(|(name, _)| *name);
    let all: Vec<&'static str> = variables.chain(constants).chain(functions).collect();
    let near = nearest(name, all.iter().copied());
    ExpressionFault::UnknownName {
        name: full.to_string(),
        nearest: near,
        list: format!("known are {}", all.join(", ")),
    }
}
