// The surface's record: kind of its material, first of its material's numbers, bits of the media that it bounds. Lanes
// without a surface may ask too, and get those of the first.
static inline integer surface_record(const struct world *world, integer surface, int member) {
    return gather(int, world->surface_records, 3 * pick(surface, (integer)0, test(surface < 0)) + member);
}
static inline integer surface_media(const struct world *world, integer surface) { return surface_record(world, surface, 2); }
