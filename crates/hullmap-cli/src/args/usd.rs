use clap::ValueEnum;

#[derive(Debug, clap::Args)]
pub struct UsdArgs {
    /// USD prim that holds the mesh, such as /World/chair
    #[arg(long, hide_short_help = true, value_name = "PATH")]
    pub prim: Option<String>,
    /// USD asset, as in the layer, such as ./chair.usd
    #[arg(long, hide_short_help = true, value_name = "ASSET")]
    pub asset: Option<String>,
    /// Length of a unit of the USD stage in metres; default 1
    #[arg(long = "set meters_per_unit", value_name = "F", value_parser = positive)]
    pub meters_per_unit: Option<f64>,
    /// Up axis of the USD stage; default z
    #[arg(long = "set stage_up", value_enum, value_name = "y|z")]
    pub stage_up: Option<StageUp>,
}

impl UsdArgs {
    pub fn given(&self) -> Option<&'static str> {
        let flags = [
            ("--prim", self.prim.is_some()),
            ("--asset", self.asset.is_some()),
            ("--set meters_per_unit", self.meters_per_unit.is_some()),
            ("--set stage_up", self.stage_up.is_some()),
        ];
        flags.into_iter().find_map(|(flag, is_given)| is_given.then_some(flag))
    }
}

/// Up axes that a stage may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum StageUp {
    /// y
    Y,
    /// z
    Z,
}

fn positive(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
    found.ok_or_else(|| "expected a number above 0, such as 1 or 0.01".to_owned())
}
