// Views that need no statistics of sphere tracing.

const steps = 0u;
const steepest = 0.0;
