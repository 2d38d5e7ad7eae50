//! Fields of answers by name: the one list from which tables, JSON and bindings are made.

use glam::DVec3;

/// Value of a field of an answer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// True or false.
    Flag(bool),
    /// One of a few words, and its number in C.
    Word(&'static str, u32),
    /// A count or an index.
    Count(u32),
    /// A length or a time.
    Number(f64),
    /// A point or a direction.
    Vector(DVec3),
    /// Indices of the parts of A and of B.
    Parts([u32; 2]),
}

/// An answer as a list of fields. Answers of one type have the same fields in the same order.
///
/// # Examples
/// ```
/// use hullmap::glam::DVec3;
/// use hullmap::shapes::Sphere;
/// use hullmap::{Cache, Fields, Pose, Settings, Value, distance};
///
/// let (ball, b_in_a) = (Sphere::new(1.0)?, Pose::from_translation(DVec3::X * 5.0)?);
/// let gap = distance(&ball, &ball, b_in_a, &Settings::default(), &mut Cache::new());
/// assert_eq!(gap.fields().nth(1), Some(("distance", Value::Number(3.0))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Fields: Default {
    /// Names and values, in the order of the struct.
    fn fields(&self) -> impl Iterator<Item = (&'static str, Value)>;
}

/// Lists the fields of an answer. One that is missing is an error of the compiler.
macro_rules! fields {
    ($answer:ident { $($field:ident)* } $(but { $($hidden:ident)* })? $(and { $name:ident: $method:ident })?) => {
        impl $crate::Fields for $answer {
            fn fields(&self) -> impl Iterator<Item = (&'static str, $crate::Value)> {
                let Self { $($field,)* $($($hidden: _,)*)? } = *self;
                let own = [$((stringify!($field), $crate::Value::from($field)),)*].into_iter();
                $(let own = [(stringify!($name), $crate::Value::Flag(self.$method()))].into_iter().chain(own);)?
                own
            }
        }
    };
}
pub(crate) use fields;

/// Names the variants of an enum.
macro_rules! words {
    ($kind:ident { $($variant:ident = $word:literal)* }) => {
        impl $kind {
            /// The word in snake case, for JSON and tables. The words are stable.
            pub fn as_str(self) -> &'static str {
                match self {
                    $(Self::$variant => $word,)*
                }
            }
        }

        impl std::fmt::Display for $kind {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.as_str())
            }
        }

        impl From<$kind> for $crate::Value {
            fn from(word: $kind) -> Self {
                Self::Word(word.as_str(), word as u32)
            }
        }
    };
}
pub(crate) use words;

macro_rules! values {
    ($($kind:ty => $value:ident),*) => {
        $(impl From<$kind> for Value {
            fn from(value: $kind) -> Self {
                Self::$value(value)
            }
        })*
    };
}
values!(bool => Flag, u32 => Count, f64 => Number, DVec3 => Vector, [u32; 2] => Parts);
