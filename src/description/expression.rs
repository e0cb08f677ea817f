//! What a person types into a field of numbers: a number, some arithmetic, or a change of what is there.

use super::Refused;
use std::f64::consts::PI;

/// A parsed field.
///
/// | typed | meaning |
/// |---|---|
/// | `1.5`, `-0.5`, `2*(1+3)/7`, `pi/2` | this number |
/// | `+0.5`, `+-0.5`, `-=0.5`, `+=0.5` | what is there, plus or minus this |
/// | `*2`, `/3`, `*=2`, `/=3` | what is there, times or divided by this |
///
/// A leading minus is a sign, because negative coordinates are typed more often than differences. Arithmetic knows
/// `+ - * /`, `^` (power), parentheses, `pi`, `rad` after a product (radians to degrees) and `deg` (no change).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Expression {
    operation: Operation,
    operand: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operation {
    Set,
    Add,
    Subtract,
    Multiply,
    Divide,
}

/// Longest text that is read, characters: arithmetic of more is not typed.
const LONGEST: usize = 200;
/// Deepest parentheses and signs.
const DEEPEST: u32 = 50;

impl Expression {
    /// Reads a field; the error tells what is wrong with it.
    pub fn parse(text: &str) -> Result<Self, Refused> {
        let text = text.trim();
        if text.len() > LONGEST {
            return Err(Refused::new("this is too long for a number"));
        }
        let prefixes = [
            ("+=", Operation::Add),
            ("-=", Operation::Subtract),
            ("*=", Operation::Multiply),
            ("/=", Operation::Divide),
            ("=", Operation::Set),
            ("+", Operation::Add),
            ("*", Operation::Multiply),
            ("/", Operation::Divide),
        ];
        let (operation, rest) = prefixes
            .into_iter()
            .find_map(|(prefix, operation)| Some((operation, text.strip_prefix(prefix)?)))
            .unwrap_or((Operation::Set, text));
        let mut reader = Reader { rest: rest.trim_start(), depth: 0 };
        let operand = reader.sum()?;
        if !reader.rest.is_empty() {
            return Err(reader.unexpected());
        }
        if !operand.is_finite() {
            return Err(Refused::new("this is not a finite number"));
        }
        if operation == Operation::Divide && operand == 0.0 {
            return Err(Refused::new("nothing can be divided by 0"));
        }
        Ok(Self { operation, operand })
    }

    /// What a field has afterwards that has `now`.
    pub fn apply(&self, now: f64) -> Result<f64, Refused> {
        let value = match self.operation {
            Operation::Set => return Ok(self.operand),
            Operation::Add => now + self.operand,
            Operation::Subtract => now - self.operand,
            Operation::Multiply => now * self.operand,
            Operation::Divide => now / self.operand,
        };
        if value.is_finite() {
            Ok(super::parameter::without_noise(value))
        } else {
            Err(Refused::new("this is not a finite number"))
        }
    }

    /// Whether the result depends on what is there.
    pub fn is_relative(&self) -> bool {
        self.operation != Operation::Set
    }
}

/// Recursive descent.
struct Reader<'a> {
    /// Begins with what comes next, blanks skipped.
    rest: &'a str,
    depth: u32,
}

impl Reader<'_> {
    fn sum(&mut self) -> Result<f64, Refused> {
        let mut value = self.product()?;
        loop {
            if self.take('+') {
                value += self.product()?;
            } else if self.take('-') {
                value -= self.product()?;
            } else {
                return Ok(value);
            }
        }
    }

    /// A unit is that of the whole product: `pi/2 rad` are 90 degrees.
    fn product(&mut self) -> Result<f64, Refused> {
        let mut value = self.signed()?;
        loop {
            if self.word("rad") {
                value = value.to_degrees();
            } else if self.word("deg") || self.take('°') {
            } else if self.take('*') {
                value *= self.signed()?;
            } else if self.take('/') {
                let divisor = self.signed()?;
                if divisor == 0.0 {
                    return Err(Refused::new("nothing can be divided by 0"));
                }
                value /= divisor;
            } else {
                return Ok(value);
            }
        }
    }

    /// A sign binds less than a power: -2^2 is -4.
    fn signed(&mut self) -> Result<f64, Refused> {
        self.deeper()?;
        let value = if self.take('-') {
            -self.signed()?
        } else if self.take('+') {
            self.signed()?
        } else {
            self.power()?
        };
        self.depth -= 1;
        Ok(value)
    }

    fn power(&mut self) -> Result<f64, Refused> {
        let base = self.atom()?;
        if self.take('^') { Ok(base.powf(self.signed()?)) } else { Ok(base) }
    }

    fn atom(&mut self) -> Result<f64, Refused> {
        if self.take('(') {
            let value = self.sum()?;
            return if self.take(')') { Ok(value) } else { Err(Refused::new("a ) is missing")) };
        }
        if self.word("pi") || self.take('π') {
            return Ok(PI);
        }
        let end = self.number_end();
        let (number, rest) = self.rest.split_at(end);
        let value = number.parse().map_err(|_| self.unexpected())?;
        self.rest = rest.trim_start();
        Ok(value)
    }

    /// Bytes of the number at the beginning: digits, a point, an exponent.
    fn number_end(&self) -> usize {
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|b| b.is_ascii_digit()).count();
        let mut end = digits(0);
        if bytes.get(end) == Some(&b'.') {
            end += 1 + digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = if end + 1 + sign <= bytes.len() { digits(end + 1 + sign) } else { 0 };
            if exponent > 0 {
                end += 1 + sign + exponent;
            }
        }
        end
    }

    fn take(&mut self, wanted: char) -> bool {
        let rest = self.rest.strip_prefix(wanted);
        self.rest = rest.map_or(self.rest, str::trim_start);
        rest.is_some()
    }

    /// A word that ends here.
    fn word(&mut self, wanted: &str) -> bool {
        let rest = self.rest.strip_prefix(wanted).filter(|rest| !rest.starts_with(char::is_alphanumeric));
        self.rest = rest.map_or(self.rest, str::trim_start);
        rest.is_some()
    }

    fn deeper(&mut self) -> Result<(), Refused> {
        self.depth += 1;
        if self.depth > DEEPEST { Err(Refused::new("this is nested too deeply")) } else { Ok(()) }
    }

    fn unexpected(&self) -> Refused {
        match self.rest.chars().next() {
            None => Refused::new("a number is missing at the end"),
            Some(',') => Refused::new("one number only, with a point for fractions"),
            Some(c) => Refused::new(format!("a number cannot go on with {c}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SplitMix64;

    fn value(text: &str, now: f64) -> f64 {
        Expression::parse(text).and_then(|e| e.apply(now)).unwrap_or_else(|e| panic!("{text}: {e}"))
    }

    #[test]
    fn what_the_table_says() {
        for (text, expected) in [
            ("1.5", 1.5),
            ("-0.5", -0.5),
            ("=-0.5", -0.5),
            (".5", 0.5),
            ("5.", 5.0),
            ("1e-3", 0.001),
            ("2*(1+3)/8", 1.0),
            ("1 - 2 - 3", -4.0),
            ("-2^2", -4.0),
            ("2^-1", 0.5),
            ("2^3^2", 512.0),
            ("pi", PI),
            ("180/pi", 180.0 / PI),
            ("pi rad", 180.0),
            ("pi/2 rad", 90.0),
            ("45 + pi/4 rad", 90.0),
            ("(1 + 1)*pi rad - 90°", 270.0),
            ("90 deg", 90.0),
            ("90°", 90.0),
            ("--3", 3.0),
            (" 7 ", 7.0),
            ("+0.5", 10.5),
            ("+-0.5", 9.5),
            ("-=0.5", 9.5),
            ("+=0.5", 10.5),
            ("*2", 20.0),
            ("*=2", 20.0),
            ("/4", 2.5),
            ("/=4", 2.5),
            ("* (1 + 1)", 20.0),
        ] {
            assert_eq!(value(text, 10.0), expected, "{text}");
        }
        assert_eq!(value("+0.1", 0.2), 0.3, "decimal steps leave no noise");
        assert_eq!(value("0.30000000000000004", 0.0), 0.30000000000000004, "a typed number is what was typed");
    }

    #[test]
    fn what_is_no_number_is_refused_with_a_reason() {
        for text in [
            "", "+", "*", "1 2", "(1", "1)", "x", "1,5", "1/0", "/0", "/(1-1)", "1e999", "nan", "inf", "pix", "2e",
            "1..2", "*-", "0x10", "é", "=", "==1",
        ] {
            let refused = Expression::parse(text).expect_err(text);
            assert!(!refused.to_string().is_empty());
        }
        assert!(Expression::parse(&"(".repeat(199)).is_err());
        assert!(Expression::parse(&"-".repeat(199)).is_err());
        assert!(Expression::parse(&"1+".repeat(500)).is_err());
        assert!(Expression::parse("*1e300").unwrap().apply(1e300).is_err());
    }

    #[test]
    fn any_text_is_read_or_refused_without_a_panic_and_numbers_survive_being_written() {
        let mut random = SplitMix64(6);
        let parts = ["1", "2.5", "+", "-", "*", "/", "^", "(", ")", "pi", "rad", "e", "E", ".", "=", " ", "é", "deg"];
        for _ in 0..20_000 {
            let count = random.next_u64() % 8;
            let text: String = (0..count).map(|_| parts[(random.next_u64() % parts.len() as u64) as usize]).collect();
            if let Ok(expression) = Expression::parse(&text) {
                let _ = expression.apply(3.0);
            }
            let number = f64::from_bits(random.next_u64());
            if number.is_finite() {
                assert_eq!(value(&format!("{number:?}"), 1.0), number);
            }
        }
    }
}
