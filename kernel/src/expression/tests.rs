use super::*;

const AT: Arguments = Arguments { x: 0.3, y: 0.7, z: 1.9, initial: [0.25, 0.75, 2.0], t: 0.35 };

/// Expressions with the values that Python 3.11.7 gives for the arguments `AT`, after
/// `from math import *`.
#[allow(clippy::approx_constant)] // values as Python prints them
const PYTHON: &[(&str, f64)] = &[
    ("1+2*3", 7.0),
    ("2**3**2", 512.0),
    ("-2**2", -4.0),
    ("2**-1", 0.5),
    ("(-8)%3", 1.0),
    ("-8%3", 1.0),
    ("8%-3", -1.0),
    ("-7//2", -4.0),
    ("7//-2", -4.0),
    ("7.5//2", 3.0),
    ("-0.5%2", 1.5),
    ("1/2", 0.5),
    ("7/2*2", 7.0),
    ("1 - 2 - 3", -4.0),
    ("1e-3*.5+1.", 1.0005),
    ("sin(2*pi*t)", 0.8090169943749475),
    ("x**2+y**2+z**2", 4.1899999999999995),
    ("X*Y-Z", -1.8125),
    ("exp(-x)*cos(y)", 0.566609028286408),
    ("1.0 if t<1 else 2.0", 1.0),
    ("1 if t>1 else 2 if t>0.5 else 3", 3.0),
    ("x<y<z", 1.0),
    ("x<z<y", 0.0),
    ("x==x and y!=x", 1.0),
    ("not x", 0.0),
    ("not x == y", 1.0),
    ("0 or 5", 5.0),
    ("3 and 0", 0.0),
    ("x or y", 0.3),
    ("min(x,y,z)", 0.3),
    ("max(1,x,y)", 1.0),
    ("abs(-x)", 0.3),
    ("pow(x,2)", 0.09),
    ("atan2(y,x)", 1.1659045405098132),
    ("math.sqrt(x)", 0.5477225575051661),
    ("log(x,2)", -1.7369655941662063),
    ("log10(100)+log2(8)", 5.0),
    ("round(2.5)+round(3.5)", 6.0),
    ("floor(-1.5)+ceil(1.2)", 0.0),
    ("sinh(x)+cosh(x)+tanh(x)", 1.641171420027594),
    ("asin(0.5)+acos(0.5)+atan(0.5)", 2.0344439357957027),
    ("-x**2", -0.09),
    ("2*-x", -0.6),
    ("+x--y", 1.0),
    ("(x if x>y else y)*2", 1.4),
    ("1 if x > 0 else 1/0", 1.0),
    ("True+True", 2.0),
    ("e**1", 2.718281828459045),
    ("fabs(-3.5)+hypot(3,4)", 8.5),
    ("degrees(pi)+radians(180)", 183.14159265358978),
    ("-5.5%3.25", 1.0),
    ("5.5%-3.25", -1.0),
    ("-5.5//3.25", -2.0),
    ("1 if not x>y and y<z or t>3 else 0", 1.0),
    ("(1 if t else 0) if t<9 else 7", 1.0),
    ("10-2*3%4+2**3//3", 10.0),
    ("-1e300*1e-10", -1e+290),
    ("expm1(1e-10)+log1p(1e-10)", 2e-10),
    ("fmod(-7,3)", -1.0),
    ("copysign(2,-1)+trunc(-2.7)", -4.0),
    ("0**0", 1.0),
    ("x<=0.3", 1.0),
    ("7%7", 0.0),
    ("-4.0%2", 0.0),
    ("pow(2,0.5)", 1.4142135623730951),
    ("round(-0.5)", 0.0),
    ("1.5e3", 1500.0),
    ("-+-x", 0.3),
    ("((((x))))", 0.3),
];

fn value(text: &str) -> f64 {
    Expression::parse(text).unwrap_or_else(|error| panic!("{error}")).evaluate(&AT)
}

fn fault(text: &str) -> ExpressionError {
    Expression::parse(text).expect_err(text)
}

#[test]
fn values_are_those_of_python() {
    for &(text, expected) in PYTHON {
        let found = value(text);
        assert!((found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(), "{text}: {found}, Python {expected}");
    }
}

#[test]
fn modules_may_be_named() {
    for text in ["math.sin(x)", "np.sin(x)", "numpy.sin(x)"] {
        assert_eq!(value(text), 0.3f64.sin());
    }
    assert_eq!(value("math.pi"), std::f64::consts::PI);
    assert!(Expression::parse("math.x").is_err());
}

/// The parser folds `1/0` to a value that is not finite, which must not reach the result.
#[test]
fn branches_that_are_not_taken_are_not_evaluated() {
    for text in [
        "1 if x > 0 else 1/0",
        "1/0 if x < 0 else 1",
        "x > 0 or 1/0",
        "1 if not (x < 0 and 1/0) else 2",
        "1 if not 1 < 0 < 1/0 else 2",
    ] {
        assert_eq!(value(text), 1.0, "{text}");
    }
}

#[test]
fn what_python_refuses_to_compute_is_not_finite() {
    for text in [
        "1/0",
        "x/0",
        "x//0",
        "x%0",
        "sqrt(-1)",
        "log(-1)",
        "log(0)",
        "exp(1000)",
        "(-8)**(1/3)",
        "max(1, 0/0)",
        "min(0/0, 1)",
        "min(1, 1/0)",
        "acos(2)",
    ] {
        assert!(!value(text).is_finite(), "{text}");
    }
}

#[test]
fn constants_are_folded() {
    for (text, expected) in [
        ("2*pi", Some(std::f64::consts::TAU)),
        ("min(3,2,1)+1", Some(2.0)),
        ("1 if 2<3 else 4", Some(1.0)),
        ("x*0", None),
    ] {
        assert_eq!(Expression::parse(text).unwrap().as_constant(), expected, "{text}");
    }
    assert_eq!(Expression::parse("x + 2*sin(pi/2)").unwrap().program.len(), 3);
    assert_eq!(Expression::parse("x if 1 else 2 + 3").unwrap().evaluate(&AT), 0.3);
    let constant = Expression::constant(-2.5);
    assert_eq!(
        (constant.as_constant(), constant.evaluate(&AT), constant.to_string()),
        (Some(-2.5), -2.5, "-2.5".to_string())
    );
}

#[test]
fn dependence_on_place_and_time() {
    for (text, time, space) in [
        ("1+2", false, false),
        ("sin(t)", true, false),
        ("x", false, true),
        ("Z", false, true),
        ("y if t<1 else 0", true, true),
    ] {
        let expression = Expression::parse(text).unwrap();
        assert_eq!((expression.depends_on_time(), expression.depends_on_space()), (time, space), "{text}");
    }
}

#[test]
fn faults_name_their_place() {
    let no_operand = |text: &str| ExpressionFault::NoOperand(text.to_string());
    let cases = [
        ("", 1, no_operand("the end of the text")),
        ("1+", 3, no_operand("the end of the text")),
        ("1+*2", 3, no_operand("`*`")),
        ("1 + not x", 5, no_operand("`not`")),
        ("()", 2, no_operand("`)`")),
        ("x if else 1", 6, no_operand("`else`")),
        ("x^2", 2, ExpressionFault::Character('^')),
        ("1 + §", 5, ExpressionFault::Character('§')),
        (".", 1, ExpressionFault::Character('.')),
        ("1e999", 1, ExpressionFault::Range("1e999".into())),
        ("2*sin", 3, ExpressionFault::NotCalled("sin".into())),
        ("sin(1,2)", 1, ExpressionFault::Arguments { name: "sin".into(), allowed: "1 argument", found: 2 }),
        ("x+max(1)", 3, ExpressionFault::Arguments { name: "max".into(), allowed: "2 or more arguments", found: 1 }),
        ("log()", 1, ExpressionFault::Arguments { name: "log".into(), allowed: "1 or 2 arguments", found: 0 }),
    ];
    for (text, position, expected) in cases {
        let error = fault(text);
        assert_eq!((error.position, error.fault), (position, expected), "{text}");
    }
    for (text, position, found) in [
        ("1 2", 3, "the number 2"),
        ("(1", 3, "the end"),
        ("1)", 2, "`)`"),
        ("x(2)", 2, "`(`"),
        ("1 if x", 7, "the end"),
        ("2x", 2, "`x`"),
        ("x = 1", 3, "`=`"),
        ("min(1;2)", 6, "';'"),
        ("1.2.3", 4, "number .3"),
    ] {
        let error = fault(text);
        assert_eq!(error.position, position, "{text}: {error}");
        assert!(error.to_string().contains(found), "{text}: {error}");
    }
}

#[test]
fn unknown_names_get_the_nearest_one() {
    let shown = fault("2*sni(x)").to_string();
    assert!(shown.contains("\"sni\" is unknown, did you mean \"sin\"?") && shown.contains("at character 3"), "{shown}");
    assert!(fault("true").to_string().contains("did you mean \"True\"?"));
    assert!(fault("x^2").to_string().contains("a power is written **"));
    assert!(fault("nan").to_string().contains("known are x, y, z"));
}

#[test]
fn deep_and_long_texts_are_refused_and_flat_ones_are_not() {
    let million = 1_000_000;
    assert_eq!(fault(&"(".repeat(million)).fault, ExpressionFault::TooLong);
    for piece in ["(", "-", "not ", "2**", "1 if x else ", "sin(", "x+("] {
        assert_eq!(fault(&piece.repeat(5_000)).fault, ExpressionFault::TooDeep, "{piece}");
    }
    assert!((value(&format!("0{}", "+x".repeat(10_000))) - 3_000.0).abs() < 1e-8);
    assert_eq!(value(&format!("max({}9)", "x,".repeat(10_000))), 9.0);
}

#[test]
fn mutations_never_panic() {
    let mut state = 20_261_122_u64;
    let mut below = |limit: usize| {
        state ^= state >> 12;
        state ^= state << 25;
        state ^= state >> 27;
        (state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % limit
    };
    let pieces = ["(", ")", "if ", " else ", "**", "//", "e", ".", "<", " and ", " not ", "min(", ",", "é", "1e9", "x"];
    let (mut good, mut bad) = (0, 0);
    for round in 0..20_000 {
        let mut text: Vec<char> = PYTHON[round % PYTHON.len()].0.chars().collect();
        for _ in 0..=below(3) {
            let at = below(text.len() + 1);
            match below(3) {
                0 if at < text.len() => drop(text.remove(at)),
                1 if at < text.len() => text[at] = char::from(32 + below(95) as u8),
                _ => drop(text.splice(at..at, pieces[below(pieces.len())].chars())),
            }
        }
        match Expression::parse(&text.iter().collect::<String>()) {
            Ok(expression) => {
                expression.evaluate(&AT);
                good += 1;
            }
            Err(error) => {
                assert!(error.position <= text.len() + 1, "{error}");
                bad += 1;
            }
        }
    }
    assert!(good > 1_000 && bad > 1_000, "{good} good, {bad} bad");
}
