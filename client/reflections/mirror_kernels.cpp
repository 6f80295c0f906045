#include "mirror_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/reflections/mirror_kernels.cpp"
#include <hwy/foreach_target.h>

#include <client/warp/warp_points-inl.h>

#include <equistream/virtual_image.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// Some of an eye's rays (unit).
struct MirrorRays {
    Vectors ray;
    Floats surface_m;
    Vectors towards;  ///< from the source's centre to what they meet; any length
    Nearest nearest;  ///< the source's sample of that
};

/// Where a ray's image was found, and whether.
struct FoundImages {
    FloatMask found;
    Positions at;
};

class ImageSearch {
public:
    explicit ImageSearch(const MirrorJob& job) : job_(job), eye_(job.rays.eye()) {}

    HWY_INLINE MirrorRays rays(Floats x, Floats y, Floats depth_m) const {
        MirrorRays r;
        const Vectors along = ray(job_.rays, x, y);
        r.ray = scaled(along, all(1.0f) / hn::Sqrt(dot(along, along)));
        r.surface_m = hn::Min(depth_m, all(far_distance_m));
        r.towards = from_source(r.ray, all(1.0f) / r.surface_m);
        r.nearest = nearest_sample(job_.grid, r.towards);
        r.nearest.covered = hn::And(r.nearest.covered, depth_m > all(0.0f));
        return r;
    }

    HWY_INLINE FloatMask specular(const Nearest& sample) const {
        return hn::And(sample.covered, value_at(job_.source.specular, sample) > all(min_specular));
    }

    HWY_INLINE Ints answers(const MirrorRays& r, Positions& at) const {
        const Floats image_m = image_distance(r.nearest);
        const FloatMask known = hn::Not(hn::IsNaN(image_m));
        const Floats w_surface = w(value_at(job_.source.depth_m, r.nearest));
        const Floats w_image = hn::IfThenElseZero(known, w(image_m));
        const FloatMask kept = hn::Abs(w_image - w_surface) <= all(job_.agreement.tolerance);
        if (!job_.looks_for_images) {
            at = {all(0.0f), all(0.0f)};
            return hn::IfThenElse(hn::RebindMask(int_tag, hn::And(known, kept)), all(int(MirrorAnswer::kept)),
                                  all(int(MirrorAnswer::gap)));
        }
        const FloatMask displaced = displaced_by_little(r, image_m);
        const FoundImages images = first_images(r, hn::AndNot(kept, known));
        at = images.at;
        Ints answer = all(int(MirrorAnswer::gap));
        const auto where = [&](FloatMask mask, MirrorAnswer value) HWY_ATTR {
            answer = hn::IfThenElse(hn::RebindMask(int_tag, mask), all(int(value)), answer);
        };
        where(displaced, MirrorAnswer::displaced);
        where(images.found, MirrorAnswer::by_image);
        where(kept, MirrorAnswer::kept);
        return answer;
    }

private:
    static Floats none() { return all(std::numeric_limits<float>::quiet_NaN()); }

    HWY_INLINE static Vectors scaled(const Vectors& v, Floats factor) {
        return {v.x * factor, v.y * factor, v.z * factor};
    }
    /// a + b scale
    HWY_INLINE static Vectors sum(const Vectors& a, const Vectors& b, Floats scale) {
        return {hn::MulAdd(b.x, scale, a.x), hn::MulAdd(b.y, scale, a.y), hn::MulAdd(b.z, scale, a.z)};
    }
    HWY_INLINE Vectors eye() const { return {all(eye_.x), all(eye_.y), all(eye_.z)}; }
    /// Direction from the source's centre to a point of a ray, of a length that stays finite.
    HWY_INLINE Vectors from_source(const Vectors& ray, Floats inverse_m) const { return sum(ray, eye(), inverse_m); }

    HWY_INLINE Floats w(Floats distance_m) const { return formulas::w_of(distance_m, job_.agreement.box_radius_m); }

    /// What a sample's mirror shows is so far away; NaN where it shows nothing, or nobody has told.
    HWY_INLINE Floats image_distance(const Nearest& sample) const {
        const ImageView<const float> images = job_.source.virtual_depth_m;
        if (images.data == nullptr)
            return none();
        const Floats image_m = value_at(images, sample);
        return hn::IfThenElse(hn::And(specular(sample), image_m > all(0.0f)), hn::Min(image_m, all(far_distance_m)),
                              none());
    }

    HWY_INLINE FloatMask displaced_by_little(const MirrorRays& r, Floats image_m) const {
        const Floats scale = image_m / hn::Sqrt(dot(r.towards, r.towards));
        const Vectors from_eye = sum(scaled(r.towards, scale), eye(), all(-1.0f));
        const Vectors beside = sum(from_eye, r.ray, hn::Neg(dot(from_eye, r.ray)));
        return dot(beside, beside) <= all(max_image_displacement * max_image_displacement) * dot(from_eye, from_eye);
    }

    // Not inlined, which takes far longer to compile.

    /// The first image on each ray beyond the surface that it meets.
    HWY_NOINLINE FoundImages first_images(const MirrorRays& r, FloatMask open) const {
        FoundImages images{hn::FirstN(float_tag, 0), {all(0.0f), all(0.0f)}};
        if (hn::AllFalse(float_tag, open))
            return images;
        const Floats nearest_inverse = all(1.0f) / r.surface_m;
        const Positions from = project(job_.grid, r.towards), to = project(job_.grid, r.ray);
        const Floats du = to.u - from.u, dv = to.v - from.v;
        const Floats apart = hn::Ceil(hn::Sqrt(hn::MulAdd(du, du, dv * dv)));
        const Floats steps = hn::Min(hn::Max(apart, all(1.0f)), all(float(max_image_steps)));
        const Floats step_inverse = nearest_inverse / steps;
        FloatMask before = open;
        for (int k = 0; k <= max_image_steps; ++k) {
            const Floats step = all(float(k));
            const FloatMask going = hn::And(open, step <= steps);
            if (hn::AllFalse(float_tag, going))
                break;
            const Floats inverse = hn::Max(hn::NegMulAdd(step, step_inverse, nearest_inverse), all(0.0f));
            const Vectors towards = from_source(r.ray, inverse);
            const Floats image_m = image_distance(nearest_sample(job_.grid, towards));
            const Floats point_inverse = inverse / hn::Sqrt(dot(towards, towards));
            // A step more: the image may lie between this sample and the next.
            const FloatMask behind = point_inverse <= all(1.0f) / image_m + step_inverse;
            const FloatMask meets = hn::And(hn::And(going, behind), hn::Or(before, step == steps));
            before = hn::Not(behind);
            if (hn::AllFalse(float_tag, meets))
                continue;
            follow(r.ray, image_m, meets, images);
            open = hn::AndNot(images.found, open);
        }
        return images;
    }

    /// From a distance along a ray to the image that the source has in that direction, to the ray's point nearest to
    /// it, and so on, until the image lies on the ray.
    HWY_NOINLINE void follow(const Vectors& ray, Floats distance_m, FloatMask open, FoundImages& images) const {
        for (int turn = 0; turn < max_image_turns && !hn::AllFalse(float_tag, open); ++turn) {
            const Vectors point = sum(eye(), ray, distance_m);
            const Floats image_m = image_distance(nearest_sample(job_.grid, point));
            const Vectors from_eye = sum(scaled(point, image_m / hn::Sqrt(dot(point, point))), eye(), all(-1.0f));
            const Floats next_m = dot(from_eye, ray);
            open = hn::And(open, next_m > all(0.0f));
            const Vectors beside = sum(from_eye, ray, hn::Neg(next_m));
            const Floats off = all(job_.agreement.tolerance) * next_m;
            const FloatMask there = hn::And(open, dot(beside, beside) <= off * off);
            if (!hn::AllFalse(float_tag, there)) {
                const Positions at = project(job_.grid, sum(eye(), ray, next_m));
                const FloatMask shown =
                    hn::And(there, hn::Not(hn::IsNaN(image_distance(nearest_sample(job_.grid, at)))));
                images.found = hn::Or(images.found, shown);
                images.at = {hn::IfThenElse(shown, at.u, images.at.u), hn::IfThenElse(shown, at.v, images.at.v)};
                open = hn::AndNot(there, open);
            }
            distance_m = next_m;
        }
    }

    const MirrorJob& job_;
    glm::vec3 eye_;
};

void find_images_here(const MirrorJob& job, int y, MirrorRow& row) {
    const hn::Rebind<std::uint8_t, IntTag> byte_tag;
    const ImageSearch search(job);
    const float* depth_m = job.eye.depth_m.row(y);
    const std::uint8_t* origin = job.origin.row(y);
    row.count = 0;
    const auto list = [&](int x, const float* depths, const std::uint8_t* origins) HWY_ATTR {
        const Ints from = hn::PromoteTo(int_tag, hn::LoadU(byte_tag, origins));
        const FloatMask own = hn::RebindMask(float_tag, from == all(int(PixelOrigin::source)));
        if (hn::AllFalse(float_tag, own))
            return;
        const MirrorRays r = search.rays(columns_from(x), all(float(y)), hn::LoadU(float_tag, depths));
        const FloatMask mirrors = hn::And(own, search.specular(r.nearest));
        row.count += int(hn::CompressStore(hn::Iota(int_tag, x), hn::RebindMask(int_tag, mirrors), int_tag,
                                           row.x.data() + row.count));
    };
    const int width = job.eye.camera.width;
    int x = 0;
    for (; x + lanes <= width; x += lanes)
        list(x, depth_m + x, origin + x);
    if (x < width) {
        float depths[lanes];
        std::uint8_t origins[lanes];
        std::fill_n(origins, lanes, std::uint8_t(PixelOrigin::gap));
        std::fill_n(depths, lanes, std::numeric_limits<float>::quiet_NaN());
        std::copy(depth_m + x, depth_m + width, depths);
        std::copy(origin + x, origin + width, origins);
        list(x, depths, origins);
    }
    for (int i = 0; i < row.count; i += lanes) {
        if (i + lanes > row.count)
            std::fill(row.x.begin() + row.count, row.x.begin() + i + lanes, row.x[std::size_t(i)]);
        const Ints columns = hn::LoadU(int_tag, row.x.data() + i);
        const MirrorRays r =
            search.rays(hn::ConvertTo(float_tag, columns), all(float(y)), hn::GatherIndex(float_tag, depth_m, columns));
        Positions at;
        const Ints answers = search.answers(r, at);
        hn::StoreU(at.u, float_tag, row.u.data() + i);
        hn::StoreU(at.v, float_tag, row.v.data() + i);
        hn::StoreU(hn::U8FromU32(hn::BitCast(hn::RebindToUnsigned<IntTag>(), answers)), byte_tag,
                   row.answer.data() + i);
    }
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(find_images_here);

// As many more as the loops may write at once beyond the last one.
MirrorRow::MirrorRow(int width) : x(std::size_t(width + tile_width)), answer(x.size()), u(x.size()), v(x.size()) {}

void find_images(const MirrorJob& job, int y, MirrorRow& row) {
    HWY_DYNAMIC_DISPATCH(find_images_here)(job, y, row);
}

}  // namespace equistream
#endif
