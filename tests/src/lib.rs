//! The tests of the whole workspace live in `tests/tests/`; this library only holds what several of them share.
