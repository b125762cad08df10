// The state of a lane: a path, the segment of it that is being walked, and the vertex from which a walk towards a light
// went out. What a scene does not use of it is never touched, and the compiler drops it.
#include "core/equiangular.h"
#include "core/rng.h"
#include "core/vector.h"

typedef struct {
    rng_address random;
    // The segment: a ray in the device's space; `length` to a walk's light, `reach` to the first surface if that is nearer,
    // `end` to the collision in a constant medium (`clock`, its index, or -1) if that is.
    vector origin, direction;
    real length, reach, end;
    real end_low;       // what rounding left of `end`
    integer clock;
    word inside;        // the meshes of media that hold the segment's origin, one bit each
    real tracked, tracked_low; // up to where tracking through grids has come, and what rounding left of it
    mask fresh;         // the segment has not begun
    mask walking;       // a walk that measures transmittance, not a flight
    mask tracking;      // inside the grids' bounds
    mask asked;         // the flight has had its equiangular vertex
    equiangular seen;   // the segment from the light of that vertex
    mask aside;         // a walk that a flight waits for: the flight goes on from the vertex afterwards
    // The path
    spectrum throughput, radiance;
    layer_values layers;
    coefficient balance; // densities of the path by channel, relative to their mean (Miller et al. 2019)
    integer hero;        // the channel by which distances are sampled
    integer order;       // scatterings so far
    real pdf;            // of the direction that was sampled last; 1e30 where no light sample could have found it
    vector departed;     // from where it was sampled: a flight passes index-matched surfaces on its way to a light
    // The vertex
    vector position, incoming;
    integer medium;     // that scatters there; -1 on a surface
    word inside_there;
    // The walk: what arrives if nothing is lost on the way, and what is not lost
    spectrum light;
    coefficient transmittance;
} path;
