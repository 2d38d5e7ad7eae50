//! Packs as files: the format as its page describes it, damaged and hostile files, files that
//! change while they are mapped.

mod damage;
mod format_document;
mod fuzz_corpus;
#[cfg(target_os = "linux")]
mod live_mapping;
mod rejections;
