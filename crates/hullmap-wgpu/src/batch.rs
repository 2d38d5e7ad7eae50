use bytemuck::{Pod, Zeroable};
use hullmap::glam::{DVec3, Vec3};
use hullmap::{Cache, Contact, Distance, Hull, Overlap, Pack, Settings};

use crate::device::{Device, DevicePack, DirectionBuffers, PairBuffers, Plan, States};
use crate::error::Error;
use crate::records::{Answer, AnswerRecord, HullRecord, IndexedPair, MAX_STEPS, PairRecord, Query, Status, Tables};

/// Where batches are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Backend {
    /// On a Vulkan device if there is one that can hold the pack, otherwise on the processor.
    Auto,
    Cpu,
    Wgpu,
}

/// A direction in which the support vertex of a hull is requested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportQuery {
    /// Index of the hull in the pack.
    pub hull: u32,
    /// The direction, in the hull's frame. It need not be of unit length.
    pub dir: Vec3,
}

/// A support vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SupportAnswer {
    /// Index of the vertex in the hull.
    pub vertex: u32,
    /// Its position, exactly.
    pub point: Vec3,
    /// Whether its dot product falls short of the maximum by at most
    /// [`SUPPORT_SHORTFALL`](crate::SUPPORT_SHORTFALL) times the outer radius. False for directions
    /// that are zero or not finite, and in damaged packs.
    pub is_certain: bool,
}

/// A direction as the kernel reads it. Its length is 1 within rounding error.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct DirectionRecord {
    dir: [f32; 3],
    hull: u32,
}

/// Output of the support kernel.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct FoundRecord {
    offset: [f32; 3],
    vertex: u32,
    is_certain: u32,
    padding: [u32; 3],
}

#[derive(Debug)]
struct Gpu {
    pack: DevicePack,
    pairs: Option<PairBuffers>,
    states: Option<States>,
    directions: Option<DirectionBuffers>,
}

/// The packs of a batch, with the number of hulls up to the end of each.
#[derive(Clone, Debug)]
struct Packs<'p>(Vec<(usize, &'p Pack)>);

impl<'p> Packs<'p> {
    fn new(packs: &[&'p Pack]) -> Self {
        let mut end = 0;
        let counted = packs.iter().map(|pack| {
            end += pack.hull_count();
            (end, *pack)
        });
        Self(counted.collect())
    }

    fn hull(&self, index: u32) -> Option<Hull<'p>> {
        let index = index as usize;
        let at = self.0.partition_point(|(end, _)| *end <= index);
        let (end, pack) = self.0.get(at)?;
        pack.hull(index + pack.hull_count() - end).ok()
    }
}

/// Solves batches of pairs of hulls of one pack, or of several. Buffers are kept from batch to
/// batch.
///
/// Answers are in the order of the pairs, and no answer depends on other pairs.
///
/// # Examples
/// ```
/// use hullmap::{Pose, Settings, glam::DVec3};
/// use hullmap_wgpu::{Backend, Batch, IndexedPair, Status};
///
/// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(200, 1));
/// let at = |x| Pose::from_translation(DVec3::new(x, 0.0, 0.0)).expect("finite");
/// let pairs = [0.1, 5.0].map(|x| IndexedPair { a: 0, b: 0, b_in_a: at(x) });
///
/// // On the GPU if there is one, otherwise on the processor.
/// let mut batch = Batch::new(&pack, Backend::Auto)?;
/// batch.distance(&pairs, &Settings::default())?;
/// // The processor finishes the undecided pairs in f64.
/// batch.settle();
/// assert_eq!(batch.answers()[0].status, Status::Overlapping);
/// assert!(batch.answers()[1].lower > 2.0);
/// # Ok::<(), hullmap_wgpu::Error>(())
/// ```
#[derive(Debug)]
pub struct Batch<'p> {
    packs: Packs<'p>,
    hulls: Vec<HullRecord>,
    gpu: Option<Gpu>,
    query: Query,
    settings: Settings,
    is_warm: bool,
    pairs: Vec<IndexedPair>,
    records: Vec<PairRecord>,
    answer_records: Vec<AnswerRecord>,
    answers: Vec<Answer>,
    vertices: Vec<SupportAnswer>,
}

impl<'p> Batch<'p> {
    /// Batches of the hulls of `pack`.
    ///
    /// # Errors
    /// With [`Backend::Wgpu`], the errors of [`Device::open`] and [`DevicePack::upload`]. With
    /// [`Backend::Auto`], these errors select the processor.
    ///
    /// # Complexity
    /// Opening the device, and one copy of the pack. For batches of other packs, open the device
    /// once and use [`Batch::on`] or [`Batch::of_packs`].
    pub fn new(pack: &'p Pack, backend: Backend) -> Result<Self, Error> {
        match backend {
            Backend::Cpu => Ok(Self::with(&[pack], Vec::new(), None)),
            Backend::Wgpu => Self::on(&Device::open()?, pack),
            Backend::Auto => Ok(match Device::open().and_then(|device| Self::on(&device, pack)) {
                Ok(batch) => batch,
                Err(_) => Self::with(&[pack], Vec::new(), None),
            }),
        }
    }

    /// Batches of the hulls of `pack` on `device`.
    ///
    /// # Errors
    /// The errors of [`DevicePack::upload`].
    pub fn on(device: &Device, pack: &'p Pack) -> Result<Self, Error> {
        Self::of_packs(device, &[pack])
    }

    /// Batches of the hulls of several packs on `device`. Indices of hulls are counted through the
    /// packs: the first hull of the second pack follows the last one of the first.
    ///
    /// # Errors
    /// The errors of [`DevicePack::upload`].
    pub fn of_packs(device: &Device, packs: &[&'p Pack]) -> Result<Self, Error> {
        let tables = Tables::from_packs(packs)?;
        let pack = DevicePack::upload_tables(device, &tables)?;
        Ok(Self::with(packs, tables.hulls, Some(Gpu { pack, pairs: None, states: None, directions: None })))
    }

    /// The processor reads the packs themselves, on every kind of processor, and needs no `hulls`.
    fn with(packs: &[&'p Pack], hulls: Vec<HullRecord>, gpu: Option<Gpu>) -> Self {
        Self {
            packs: Packs::new(packs),
            hulls,
            gpu,
            query: Query::Distance,
            settings: Settings::default(),
            is_warm: false,
            pairs: Vec::new(),
            records: Vec::new(),
            answer_records: Vec::new(),
            answers: Vec::new(),
            vertices: Vec::new(),
        }
    }

    /// Where batches are solved: [`Backend::Cpu`] or [`Backend::Wgpu`].
    pub fn backend(&self) -> Backend {
        if self.gpu.is_some() { Backend::Wgpu } else { Backend::Cpu }
    }

    /// Solves all later batches on the processor, for instance after [`Error::Device`].
    ///
    /// # Examples
    /// ```
    /// # let pack = hullmap_testkit::packs::tree_pack(&shapes::families::rock(60, 1));
    /// use hullmap_wgpu::{Backend, Batch};
    ///
    /// let mut batch = Batch::new(&pack, Backend::Auto)?;
    /// batch.use_processor();
    /// assert_eq!(batch.backend(), Backend::Cpu);
    /// assert_eq!(batch.kernel_seconds(), None);
    /// assert!(batch.answers().is_empty() && batch.records().1.is_empty());
    /// # Ok::<(), hullmap_wgpu::Error>(())
    /// ```
    pub fn use_processor(&mut self) {
        self.gpu = None;
    }

    /// Sets whether each pair of later batches starts from the simplex with which the pair of the
    /// same index ended in the last batch on this device. Answers then differ within their
    /// intervals. The processor ignores it.
    pub fn set_warm(&mut self, is_warm: bool) {
        self.is_warm = is_warm;
    }

    /// Time that the kernels of the last batch took, in seconds: without preparing, copying and
    /// reading back. `None` if the device has no clock, or the processor solved the batch.
    pub fn kernel_seconds(&self) -> Option<f64> {
        self.gpu.as_ref()?.pairs.as_ref()?.seconds()
    }

    /// Whether the hulls of each pair overlap. The answers are in [`answers`](Self::answers).
    ///
    /// [`Status::Separated`] and [`Status::Overlapping`] are proven. The interval of the distance
    /// is valid, but as wide as it was when the answer was known.
    ///
    /// # Errors
    /// [`Error::Device`] if the device failed. There are no answers then.
    ///
    /// # Complexity
    /// At most [`MAX_STEPS`] support calls for each pair.
    pub fn intersects(&mut self, pairs: &[IndexedPair]) -> Result<&[Answer], Error> {
        self.solve(pairs, Query::Intersects, &Settings::default())
    }

    /// Distance of the hulls of each pair. The answers are in [`answers`](Self::answers), too.
    ///
    /// # Errors
    /// [`Error::Device`] if the device failed. There are no answers then.
    ///
    /// # Complexity
    /// At most [`MAX_STEPS`] support calls for each pair, or `settings.max_iterations` if that is
    /// less.
    pub fn distance(&mut self, pairs: &[IndexedPair], settings: &Settings) -> Result<&[Answer], Error> {
        self.solve(pairs, Query::Distance, settings)
    }

    /// Penetration depth of the hulls of each pair: the interval of the answers contains the depth,
    /// and moving B by the depth along `normal` makes the hulls touch.
    ///
    /// Kernels expand a polytope of at most 64 vertices. On smooth hulls that leaves intervals
    /// wider than the default tolerance, with [`Status::Budget`]: choose a tolerance of 1e-2 or
    /// 1e-3, or [`settle`](Self::settle) them. [`Status::Stalled`] is a proven overlap here.
    ///
    /// # Errors
    /// [`Error::Device`] if the device failed. There are no answers then.
    ///
    /// # Complexity
    /// At most [`MAX_STEPS`] support calls for each pair.
    pub fn contact(&mut self, pairs: &[IndexedPair], settings: &Settings) -> Result<&[Answer], Error> {
        self.solve(pairs, Query::Contact, settings)
    }

    /// Answers of the last batch, in the order of its pairs.
    pub fn answers(&self) -> &[Answer] {
        &self.answers
    }

    /// Inputs and outputs of the kernel in the last batch. Empty if the processor solved it.
    pub fn records(&self) -> (&[PairRecord], &[AnswerRecord]) {
        (&self.records, &self.answer_records)
    }

    fn solve(&mut self, pairs: &[IndexedPair], query: Query, settings: &Settings) -> Result<&[Answer], Error> {
        (self.query, self.settings) = (query, *settings);
        self.answer_records.clear();
        self.answers.clear();
        self.records.clear();
        self.pairs.clear();
        self.pairs.extend_from_slice(pairs);
        let Some(gpu) = &mut self.gpu else {
            self.answers.extend(pairs.iter().map(|pair| on_processor(&self.packs, pair, query, settings)));
            return Ok(&self.answers);
        };
        self.records.extend(pairs.iter().map(|pair| PairRecord::prepare(pair, &self.hulls)));
        let max_steps = settings.max_iterations.min(MAX_STEPS);
        let plan = Plan {
            query,
            // NaN and negative tolerances count as 0.
            tolerance: settings.tolerance.max(0.0) as f32,
            max_steps,
            is_warm: self.is_warm,
        };
        let answers = &mut self.answer_records;
        if let Err(error) = PairBuffers::run(&mut gpu.pairs, &mut gpu.states, &gpu.pack, plan, &self.records, answers) {
            answers.clear();
            return Err(error);
        }
        let solved = answers.iter().zip(&self.records);
        self.answers.extend(solved.map(|(answer, pair)| Answer::from_record(answer, pair, &self.hulls)));
        Ok(&self.answers)
    }

    /// Solves on the processor, in f64, the pairs that the last batch left unsettled, and returns
    /// their number. Their answers are the processor's own, bit for bit.
    ///
    /// A pair that is still [`Status::Open`] touches within the rounding error of f64.
    ///
    /// # Complexity
    /// One query of `hullmap` for each of these pairs.
    pub fn settle(&mut self) -> usize {
        if self.answer_records.is_empty() {
            // The processor solved the batch.
            return 0;
        }
        let mut settled = 0;
        for (pair, answer) in self.pairs.iter().zip(&mut self.answers) {
            if answer.status.is_unsettled() {
                *answer = on_processor(&self.packs, pair, self.query, &self.settings);
                settled += 1;
            }
        }
        settled
    }

    /// Support vertex of each query's hull.
    ///
    /// # Errors
    /// [`Error::Device`] if the device failed.
    pub fn support(&mut self, queries: &[SupportQuery]) -> Result<&[SupportAnswer], Error> {
        self.vertices.clear();
        let nothing = SupportAnswer { vertex: 0, point: Vec3::ZERO, is_certain: false };
        let unit = |dir: Vec3| dir.as_dvec3().try_normalize().map(DVec3::as_vec3);
        let Some(gpu) = &mut self.gpu else {
            self.vertices.extend(queries.iter().map(|query| match self.packs.hull(query.hull) {
                Some(hull) => {
                    let found = hull.support(query.dir);
                    SupportAnswer { vertex: found.index, point: found.point, is_certain: unit(query.dir).is_some() }
                }
                None => nothing,
            }));
            return Ok(&self.vertices);
        };
        let is_whole = |hull: u32| self.hulls.get(hull as usize).is_some_and(|hull| hull.block_count > 0);
        let directions: Vec<DirectionRecord> = queries
            .iter()
            .map(|query| match unit(query.dir).filter(|_| is_whole(query.hull)) {
                Some(dir) => DirectionRecord { dir: dir.to_array(), hull: query.hull },
                None => DirectionRecord { dir: [0.0; 3], hull: PairRecord::REJECTED },
            })
            .collect();
        let mut found: Vec<FoundRecord> = Vec::with_capacity(queries.len());
        DirectionBuffers::run(&mut gpu.directions, &gpu.pack, &directions, &mut found)?;
        self.vertices.extend(queries.iter().zip(&found).map(|(query, found)| {
            let Some(hull) = self.packs.hull(query.hull) else { return nothing };
            let is_certain = found.is_certain != 0;
            if !is_certain && unit(query.dir).is_some() {
                // Too many nodes or blocks for the kernel.
                let found = hull.support(query.dir);
                return SupportAnswer { vertex: found.index, point: found.point, is_certain: true };
            }
            match hull.vertex(found.vertex) {
                Some(point) => SupportAnswer { vertex: found.vertex, point, is_certain },
                None => nothing,
            }
        }));
        Ok(&self.vertices)
    }
}

fn on_processor(packs: &Packs<'_>, pair: &IndexedPair, query: Query, settings: &Settings) -> Answer {
    let (Some(a), Some(b)) = (packs.hull(pair.a), packs.hull(pair.b)) else {
        return Answer::UNKNOWN;
    };
    match query {
        Query::Intersects => {
            let found = hullmap::intersects(&a, &b, pair.b_in_a, &mut Cache::new());
            let status = match found.status {
                Overlap::Separated => Status::Separated,
                Overlap::Overlapping => Status::Overlapping,
                Overlap::Touching => Status::Open,
                Overlap::Undecided => Status::Budget,
            };
            let upper = if status == Status::Overlapping { 0.0 } else { f64::INFINITY };
            Answer { status, upper, steps: found.support_calls, ..Answer::UNKNOWN }
        }
        Query::Contact => of_contact(&hullmap::contact(&a, &b, pair.b_in_a, settings, &mut Cache::new())),
        Query::Distance => of_distance(&hullmap::distance(&a, &b, pair.b_in_a, settings, &mut Cache::new())),
    }
}

fn of_contact(found: &Contact) -> Answer {
    use hullmap::Status as Ended;
    let status = match found.status {
        Ended::Separated => Status::Separated,
        Ended::IterationLimit => Status::Budget,
        Ended::Exact | Ended::Within if found.depth_lower > 0.0 => Status::Overlapping,
        _ if found.depth_lower > 0.0 => Status::Stalled,
        _ => Status::Open,
    };
    Answer {
        status,
        lower: found.depth_lower,
        upper: found.depth_upper,
        normal: found.normal,
        point_a: found.point_a,
        point_b: found.point_b,
        steps: found.support_calls,
    }
}

fn of_distance(found: &Distance) -> Answer {
    use hullmap::Status as Ended;
    let status = match found.status {
        Ended::Overlapping => Status::Overlapping,
        Ended::IterationLimit => Status::Budget,
        Ended::Exact | Ended::Within if found.lower > 0.0 => Status::Separated,
        _ if found.lower > 0.0 => Status::Stalled,
        _ => Status::Open,
    };
    Answer {
        status,
        lower: found.lower,
        upper: found.upper,
        normal: found.normal,
        point_a: found.point_a,
        point_b: found.point_b,
        steps: found.support_calls,
    }
}
