// Views without statistics of sphere tracing. Takes the place of march_stats.wgsl.

const steps = 0u;
const steepest = 0.0;
