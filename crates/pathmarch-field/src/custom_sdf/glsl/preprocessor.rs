//! Preprocessor: `#define`, `#undef`, `#if` and its kin. naga's own accepts no code of which it knows no directive, and its
//! macros grow without bound.

use super::conditions::integer;
use super::lexer::{Kind, Place, Token, fault};
use super::macros::Macros;
use crate::custom_sdf::CodeDiagnostic;

/// Largest number of tokens of a preprocessed code.
const MAX_TOKENS: usize = 1 << 15;
/// Directives that mean nothing to a field.
const IGNORED: [&str; 5] = ["version", "extension", "pragma", "line", "include"];

/// Code without directives.
pub(super) struct Preprocessed<'a> {
    pub(super) tokens: Vec<Token<'a>>,
    /// True if the macro `providesInit` of Fragmentarium is defined.
    pub(super) provides_init: bool,
}

/// An `#if` and what follows it.
struct Group {
    /// True if the tokens around it are used.
    outer: bool,
    /// True if one of its branches has been used.
    taken: bool,
    /// True if the present branch is used.
    live: bool,
    at: Place,
}

/// Runs the directives of a code and expands its macros.
pub(super) fn preprocess<'a>(code: &[Token<'a>]) -> Result<Preprocessed<'a>, CodeDiagnostic> {
    let mut work = Preprocessor { macros: Macros::default(), groups: Vec::new(), tokens: Vec::new() };
    let mut rest = code;
    while let Some(first) = rest.first() {
        let is_directive = first.is("#") && first.starts_line;
        let next = |token: &Token| match is_directive {
            true => token.starts_line,
            false => token.is("#") && token.starts_line,
        };
        let length = 1 + rest[1..].iter().position(next).unwrap_or(rest.len() - 1);
        let (part, after) = rest.split_at(length);
        match is_directive {
            true => work.directive(part)?,
            false => work.text(part)?,
        }
        rest = after;
    }
    if let Some(group) = work.groups.last() {
        return Err(fault(group.at, "This `#if` has no `#endif`.", "not closed", ""));
    }
    Ok(Preprocessed { provides_init: work.macros.contains("providesInit"), tokens: work.tokens })
}

struct Preprocessor<'a> {
    macros: Macros<'a>,
    groups: Vec<Group>,
    tokens: Vec<Token<'a>>,
}

impl<'a> Preprocessor<'a> {
    fn live(&self) -> bool {
        self.groups.last().is_none_or(|group| group.live)
    }

    fn text(&mut self, tokens: &[Token<'a>]) -> Result<(), CodeDiagnostic> {
        if !self.live() {
            return Ok(());
        }
        self.tokens.extend(self.macros.expand(tokens)?);
        match self.tokens.get(MAX_TOKENS) {
            None => Ok(()),
            Some(token) => {
                let message =
                    format!("The code has more than {MAX_TOKENS} words and signs after its macros are expanded.");
                Err(fault(token.at, message, "too long from here", "Use functions for what macros repeat."))
            }
        }
    }

    fn directive(&mut self, line: &[Token<'a>]) -> Result<(), CodeDiagnostic> {
        let Some(word) = line.get(1) else { return Ok(()) };
        let rest = &line[2..];
        let name = || match rest.first() {
            Some(token) if token.is_name() => Ok(token.text),
            _ => Err(fault(word.at, format!("`#{}` needs a name.", word.text), "expected a name", "")),
        };
        match word.text {
            "ifdef" => self.open(word.at, |work| Ok(work.macros.contains(name()?))),
            "ifndef" => self.open(word.at, |work| Ok(!work.macros.contains(name()?))),
            "if" => self.open(word.at, |work| work.condition(rest, word.at)),
            "elif" => {
                let decides = self.groups.last().is_some_and(|group| group.outer && !group.taken);
                let holds = decides && self.condition(rest, word.at)?;
                self.branch(word, holds)
            }
            "else" => self.branch(word, true),
            "endif" => self.groups.pop().map(drop).ok_or_else(|| unopened(word)),
            _ if !self.live() => Ok(()),
            "define" => self.macros.define(rest, word.at),
            "undef" => name().map(|name| self.macros.undefine(name)),
            "error" => Err(fault(word.at, "The code refuses itself with `#error`.", "here", "")),
            word if IGNORED.contains(&word) => Ok(()),
            other => {
                let help = "A field knows #define, #undef, #if, #ifdef, #ifndef, #elif, #else and #endif, and skips the \
                            directives of Fragmentarium.";
                Err(fault(word.at, format!("`#{other}` is not known."), "not a directive", help))
            }
        }
    }

    fn open(
        &mut self,
        at: Place,
        condition: impl FnOnce(&mut Self) -> Result<bool, CodeDiagnostic>,
    ) -> Result<(), CodeDiagnostic> {
        let outer = self.live();
        let live = outer && condition(self)?;
        self.groups.push(Group { outer, taken: live, live, at });
        Ok(())
    }

    fn branch(&mut self, word: &Token, holds: bool) -> Result<(), CodeDiagnostic> {
        let group = self.groups.last_mut().ok_or_else(|| unopened(word))?;
        group.live = group.outer && !group.taken && holds;
        group.taken |= group.live;
        Ok(())
    }

    fn condition(&mut self, line: &[Token<'a>], at: Place) -> Result<bool, CodeDiagnostic> {
        let tokens = self.without_defined(line);
        let tokens = self.macros.expand(&tokens)?;
        // Names that are no macros are zero.
        let value = integer(&tokens, &|_| Some(0));
        let help = "It consists of integers, macros, `defined(NAME)` and operators.";
        value.map(|value| value != 0).ok_or_else(|| fault(at, "This condition cannot be evaluated.", "here", help))
    }

    /// Replaces `defined NAME` and `defined(NAME)` by 1 or 0.
    fn without_defined(&self, line: &[Token<'a>]) -> Vec<Token<'a>> {
        let mut tokens = Vec::new();
        let mut rest = line;
        while let Some((first, after)) = rest.split_first() {
            rest = after;
            if !first.is("defined") {
                tokens.push(*first);
                continue;
            }
            let bracket = usize::from(rest.first().is_some_and(|token| token.is("(")));
            let known = rest.get(bracket).is_some_and(|token| self.macros.contains(token.text));
            tokens.push(Token { kind: Kind::Number, text: if known { "1" } else { "0" }, ..*first });
            rest = rest.get(1 + 2 * bracket..).unwrap_or_default();
        }
        tokens
    }
}

fn unopened(word: &Token) -> CodeDiagnostic {
    fault(word.at, format!("There is no `#if` before this `#{}`.", word.text), "not open", "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::custom_sdf::glsl::lexer::tokens;

    fn texts(code: &str) -> String {
        let code = tokens(code);
        let texts: Vec<&str> = match preprocess(&code) {
            Ok(result) => result.tokens.iter().map(|token| token.text).collect(),
            Err(fault) => return fault.message,
        };
        texts.join(" ")
    }

    #[test]
    fn macros_with_and_without_arguments_expand() {
        assert_eq!(texts("#define R(a) mat2(cos(a),-a)\np*=R(x+1);"), "p *= mat2 ( cos ( x + 1 ) , - x + 1 ) ;");
        assert_eq!(texts("#define A B\n#define B A+1\nA"), "A + 1");
        assert_eq!(texts("#define F(x) x x\nF(F(a)) F"), "a a a a F");
        assert_eq!(texts("#define G F\n#define F(x) [x]\nG(1)"), "[ 1 ]");
        assert_eq!(texts("#define Z() 0\nZ()"), "0");
        assert_eq!(texts("#define F(a,b) a\nF(1)"), "The macro `F` takes 2 arguments, not 1.");
    }

    #[test]
    fn branches_are_chosen() {
        assert_eq!(texts("#define N 3\n#if N > 2 && defined(N)\na\n#elif 1\nb\n#else\nc\n#endif"), "a");
        assert_eq!(texts("#ifdef N\na\n#if 1\nb\n#endif\n#else\nc\n#endif"), "c");
        assert_eq!(texts("#if 0\n@ #bad\n#else\nx\n#endif"), "x");
        assert_eq!(texts("#if 1"), "This `#if` has no `#endif`.");
        assert_eq!(texts("#endif"), "There is no `#if` before this `#endif`.");
    }

    #[test]
    fn macros_that_double_are_stopped() {
        let doubling: String = (0..60).map(|k| format!("#define A{} A{k} A{k}\n", k + 1)).collect();
        assert_eq!(texts(&format!("{doubling}A60")), "The macros of this code expand to too much.");
        let nested = format!("#define F(x) x x\n{}1{}", "F(".repeat(60), ")".repeat(60));
        assert_eq!(texts(&nested), "The macros of this code expand to too much.");
        let deep = format!("#define F(x) x\n{}1{}", "F(".repeat(6000), ")".repeat(6000));
        assert_eq!(texts(&deep), "The macros of this code expand to too much.");
    }
}
