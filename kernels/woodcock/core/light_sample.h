// What next-event estimation takes from a light: the unit direction towards the sampled point and its distance (1e30 where
// the light lies at infinity), radiance divided by density, and that density per solid angle (0 where no path could find
// the light by itself, so that the sample stands alone).
typedef struct {
    vector towards;
    real distance;
    spectrum weight;
    real pdf;
} light_sample;
