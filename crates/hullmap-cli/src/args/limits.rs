use hullmap_import::Limits;

const HEADING: &str = "Limits";

/// Limits on source files.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct LimitArgs {
    /// Maximum size of a source file in bytes; importing takes up to 96 MiB of memory plus 8 times
    /// the size of the file
    #[arg(
        long = "set max_input_bytes", value_name = "N", help_heading = HEADING, default_value_t = Limits::DEFAULT.input_bytes,
        value_parser = clap::value_parser!(u64).range(1..)
    )]
    max_input_bytes: u64,
    /// Maximum number of objects in a file that is split
    #[arg(long = "set max_objects", value_name = "N", help_heading = HEADING, default_value_t = Limits::DEFAULT.objects)]
    max_objects: usize,
    /// Maximum number of vertices and corners that instances and compression add to a glTF file
    #[arg(long = "set max_instanced", value_name = "N", help_heading = HEADING, default_value_t = Limits::DEFAULT.repeated_vertices)]
    max_instanced: usize,
}

impl LimitArgs {
    pub fn limits(&self) -> Limits {
        Limits { input_bytes: self.max_input_bytes, objects: self.max_objects, repeated_vertices: self.max_instanced }
    }
}
