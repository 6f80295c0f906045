#include "map_kernels.h"

#include "coefficients.h"

#include <equistream/virtual_image.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/confidence/map_kernels.cpp"
#include <hwy/foreach_target.h>

#include "map_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

using reliability_model::groups;

/// Tables that lanes can be gathered from, by group.
struct Shares {
    Shares() {
        for (int group = 0; group < risk_group_count; ++group)
            std::ranges::copy(groups[std::size_t(group)].share_255, share_255[group]);
    }
    std::int32_t share_255[risk_group_count][reliability_model::table_size];
};

HWY_INLINE Floats log_of(Floats x) {
    return formulas::log_of(x);
}

using Risks = std::array<Floats, risk_count>;

HWY_INLINE Floats& of(Risks& risks, Risk risk) {
    return risks[std::size_t(risk)];
}

/// Steps along the row too: out and back again through each stretch that is not the source's.
HWY_INLINE void fill_row(const std::uint8_t* columns, int width, std::uint8_t* out) {
    std::copy_n(columns, width, out);
    constexpr int block = int(hn::MaxLanes(BlockTag()));
    for (int x = 0; x < width; ++x) {
        while (x + block <= width && hn::AllTrue(block_tag, load_block(out + x) == hn::Zero(block_tag)))
            x += block;
        while (x < width && out[x] == 0)
            ++x;
        if (x == width)
            return;
        int steps = x > 0 ? 0 : 255;
        for (; x < width && out[x] != 0; ++x)
            steps = out[x] = std::uint8_t(std::min<int>(out[x], std::min(steps, 254) + 1));
        steps = x < width ? 0 : 255;
        for (int back = x - 1; back >= 0 && out[back] != 0; --back)
            steps = out[back] = std::uint8_t(std::min<int>(out[back], std::min(steps, 254) + 1));
    }
}

/// loss_at, as a sum of lines each of which rises over one stretch of texture only.
class LossLines {
public:
    explicit LossLines(const VisibleLoss& loss) : first_(equistream::loss_at(loss, textures.front())) {
        for (std::size_t i = 0; i < slopes_.size(); ++i) {
            const float rise = equistream::loss_at(loss, textures[i + 1]) - equistream::loss_at(loss, textures[i]);
            slopes_[i] = rise / (textures[i + 1] - textures[i]);
        }
        any_ = loss != VisibleLoss{};
    }
    bool any() const { return any_; }
    HWY_INLINE Floats at(Floats texture) const {
        Floats loss = all(first_);
        for (std::size_t i = 0; i < slopes_.size(); ++i) {
            const Floats along = hn::Max(texture - all(textures[i]), all(0.0f));
            loss = hn::MulAdd(all(slopes_[i]), hn::Min(along, all(textures[i + 1] - textures[i])), loss);
        }
        return loss;
    }

private:
    static constexpr auto& textures = VisibleLoss::textures;
    float first_;
    std::array<float, textures.size() - 1> slopes_;
    bool any_;
};

/// The loop over a band's rows, with what it keeps from one to the next.
class Judge {
public:
    Judge(const MapJob& job, int first, int last)
        : job_(job), width_(job.width), height_(job.picture.origin.height()), first_(first),
          planar_(width_, last - first + 2 * planar_reach), closeness_rows_(width_, last - first),
          texture_rows_(job, first), texture_(width_, 1), bytes_(width_, 3), loss_(job.numbers.visible_loss) {
        if (job.filled.data == nullptr)
            std::fill_n(bytes_.row(1), width_, std::uint8_t{0});
        if (job.numbers.has_depth())
            for (int y = first - planar_reach; y < last + planar_reach; ++y) {
                if (y < 0 || y >= height_)
                    continue;
                inverse_planar_row(job.numbers, y, planar_.row(y - first + planar_reach));
                planar_.repeat_ends(y - first + planar_reach, width_);
            }
        closeness_rows_.mark(job, first, last, [this](int y) { return planar(y); });
    }

    HWY_INLINE void row(int y) {
        std::uint8_t *closeness = bytes_.row(0), *filled = bytes_.row(1), *detail = bytes_.row(2);
        closeness_rows_.closeness(y, closeness);
        texture_rows_.next(texture_.row(0));
        if (job_.filled.data != nullptr)
            fill_row(job_.filled.row(y), width_, filled);
        const int step = job_.numbers.step;
        const std::uint8_t *above = job_.along.row(std::max(0, y - step)), *here = job_.along.row(y),
                           *below = job_.along.row(std::min(height_ - 1, y + step));
        over_blocks(width_, [&](int x) HWY_ATTR {
            hn::StoreU(hn::Max(load_block(here + x), hn::Max(load_block(above + x), load_block(below + x))), block_tag,
                       detail + x);
        });
        over_row(width_, [&](int x) HWY_ATTR { judge(x, y, closeness, filled, detail); });
    }

private:
    static constexpr int planar_reach = 4;

    const float* planar(int y) const { return planar_.row(std::clamp(y, 0, height_ - 1) - first_ + planar_reach); }

    HWY_INLINE void shape(int x, int y, Floats detail, Risks& risks, Floats& parallax_px, Ints& mirrored) const {
        const RiskNumbers& n = job_.numbers;
        const float inverse_focal = 1 / n.focal_px;
        const float* row = planar(y);
        const Floats a = (columns_from(x) + all(0.5f - 0.5f * float(width_))) * all(inverse_focal);
        const Floats b = all((0.5f * float(height_) - float(y) - 0.5f) * inverse_focal);
        const Floats q = hn::LoadU(float_tag, row + x);
        const formulas::Number across =
            formulas::believed_step(hn::LoadU(float_tag, row + x - 1), q, hn::LoadU(float_tag, row + x + 1));
        const formulas::Number down = formulas::believed_step(hn::LoadU(float_tag, planar(y - 1) + x), q,
                                                              hn::LoadU(float_tag, planar(y + 1) + x));
        const formulas::SurfaceRisks surface =
            formulas::surface_risks(a, b, q, n.focal_px * across, -n.focal_px * down, seen_);
        of(risks, Risk::blur) = detail * surface.blur.lanes;
        of(risks, Risk::minification) = detail * surface.minification.lanes;
        of(risks, Risk::grazing) = detail * surface.grazing.lanes;
        parallax_px = all(n.focal_px * n.baseline_m) * surface.inverse_m.lanes;
        of(risks, Risk::parallax) = parallax_counts_ || tells() ? log_of(parallax_px) : all(0.0f);
        mirrored = n.mirrors ? mirrors_at(x, y, q) : all(0);
    }

    HWY_INLINE void flat(Floats detail, Risks& risks) const {
        const RiskNumbers& n = job_.numbers;
        const float doublings = std::log2(n.density);
        of(risks, Risk::blur) = detail * all(std::clamp(-doublings, 0.0f, max_halvings));
        of(risks, Risk::minification) = detail * all(std::clamp(doublings, 0.0f, max_halvings));
        of(risks, Risk::grazing) = all(0.0f);
        of(risks, Risk::parallax) = log_of(all(n.focal_px * n.baseline_m));
    }

    /// -1 where the source's nearest sample is of a mirror.
    HWY_INLINE Ints mirrors_at(int x, int y, Floats q) const {
        const Vectors r = ray(job_.rays, columns_from(x), all(float(y)));
        const glm::vec3 eye = job_.rays.eye();
        const Nearest sample =
            nearest_sample(job_.grid, Vectors{hn::MulAdd(all(eye.x), q, r.x), hn::MulAdd(all(eye.y), q, r.y),
                                              hn::MulAdd(all(eye.z), q, r.z)});
        const FloatMask mirror = hn::And(sample.covered, value_at(job_.specular, sample) > all(min_specular));
        return hn::VecFromMask(int_tag, hn::RebindMask(int_tag, mirror));
    }

    HWY_INLINE void judge(int x, int y, const std::uint8_t* closeness, const std::uint8_t* filled,
                          const std::uint8_t* details) {
        const RiskNumbers& n = job_.numbers;
        Risks risks;
        const Floats half = all(0.5f), one = all(1.0f);
        const Floats contrast = bytes_as_floats(job_.contrast.row(y) + x);
        const Floats detail = log_of(half * bytes_as_floats(details + x));
        of(risks, Risk::contrast) = log_of(half * contrast);
        of(risks, Risk::detail) = detail;
        const Floats texture = log_of(half * hn::LoadU(float_tag, texture_.row(0) + x));
        of(risks, Risk::texture) = texture;
        Floats parallax_px = all(0.0f);
        Ints mirrored = all(0);
        if (n.has_depth())
            shape(x, y, detail, risks, parallax_px, mirrored);
        else
            flat(detail, risks);
        const Floats close = bytes_as_floats(closeness + x);
        of(risks, Risk::silhouette_0) = hn::IfThenElseZero(close >= all(3.0f), one);
        of(risks, Risk::silhouette_1) = hn::IfThenElseZero(close >= all(2.0f), one);
        of(risks, Risk::silhouette_2) = hn::Min(close, one);
        of(risks, Risk::depth_error) = n.depth_error_px > 0 ? log_of(all(n.depth_error_px) * contrast) : all(0.0f);
        of(risks, Risk::outside) = all(n.outside);
        const hn::Repartition<std::uint8_t, IntTag> rgba_tag;
        const auto brightest = worst_channel(hn::LoadU(rgba_tag, job_.picture.rgba.pixel(x, y)));
        of(risks, Risk::brightness) = hn::ConvertTo(float_tag, hn::PromoteTo(int_tag, brightest)) * all(1 / 255.0f);

        const Ints origin = hn::PromoteTo(int_tag, hn::LoadU(byte_tag, job_.picture.origin.pixel(x, y)));
        const IntMask from_source = origin == all(int(PixelOrigin::source));
        Ints result = all(0);
        if (hn::AllTrue(int_tag, hn::AndNot(hn::MaskFromVec(mirrored), from_source))) {
            of(risks, Risk::fill_depth) = of(risks, Risk::specular) = all(0.0f);
            result = share(group_of_origin_[std::size_t(PixelOrigin::source)], risks);
        } else {
            of(risks, Risk::fill_depth) = log_of(bytes_as_floats(filled + x));
            of(risks, Risk::specular) =
                hn::IfThenElseZero(hn::RebindMask(float_tag, hn::And(from_source, hn::MaskFromVec(mirrored))),
                                   log_of(half * contrast * hn::Min(one, parallax_px)));
            result = of_mixed_groups(groups_of(origin, mirrored), risks);
        }
        if (tells())
            tell(x, y, risks, groups_of(origin, mirrored));
        if (job_.untouched)
            result = hn::IfThenElse(from_source, all(255), result);
        if (loss_.any())
            result = hn::NearestInt(hn::ConvertTo(float_tag, result) * Floats(formulas::kept_share(loss_.at(texture))));
        hn::StoreU(hn::U8FromU32(hn::BitCast(hn::RebindToUnsigned<IntTag>(), result)), byte_tag, job_.out.row(y) + x);
    }

    bool tells() const { return job_.risks.data != nullptr; }

    void tell(int x, int y, const Risks& risks, Ints group) const {
        alignas(64) float values[lanes];
        const int count = std::min(lanes, width_ - x);
        for (int k = 0; k < risk_count; ++k) {
            hn::Store(risks[std::size_t(k)], float_tag, values);
            for (int i = 0; i < count; ++i)
                job_.risks.pixel(x + i, y)[k] = values[i];
        }
        alignas(64) std::int32_t numbers[lanes];
        hn::Store(group, int_tag, numbers);
        for (int i = 0; i < count; ++i)
            *job_.groups.pixel(x + i, y) = numbers[i] < risk_group_count ? std::uint8_t(numbers[i]) : no_risk_group;
    }

    /// risk_group_count for what belongs to none.
    HWY_INLINE Ints groups_of(Ints origin, Ints mirrored) const {
        const Ints group = hn::GatherIndex(int_tag, group_of_origin_.data(), hn::Min(origin, all(pixel_origin_count)));
        const IntMask mirrors = hn::And(origin == all(int(PixelOrigin::source)), hn::MaskFromVec(mirrored));
        return hn::IfThenElse(mirrors, all(int(RiskGroup::mirrored)), group);
    }

    HWY_INLINE Ints of_mixed_groups(Ints group, const Risks& risks) const {
        Ints result = all(0);
        for (int g = 0; g < risk_group_count; ++g) {
            const IntMask takes = group == all(g);
            if (!hn::AllFalse(int_tag, takes))
                result = hn::IfThenElse(takes, share(g, risks), result);
        }
        return result;
    }

    HWY_INLINE Ints share(int group, const Risks& risks) const {
        const std::array<float, risk_count>& weights = groups[std::size_t(group)].weights;
        Floats sum = all(0.0f);
        for (std::size_t k = 0; k < risks.size(); ++k)
            sum = hn::MulAdd(all(weights[k]), risks[k], sum);
        const Floats entry =
            hn::Min(sum * all(reliability_model::entries_per_unit), all(float(reliability_model::table_size - 1)));
        return hn::GatherIndex(int_tag, shares_.share_255[group], hn::ConvertTo(int_tag, entry));
    }

    static formulas::SourceSeen seen_from(const RiskNumbers& n) {
        return {n.centre.x, n.centre.y, n.centre.z, n.pole.x, n.pole.y, n.pole.z, n.density};
    }

    static bool counts(Risk risk) {
        return std::ranges::any_of(groups, [risk](const auto& group) { return group.weights[std::size_t(risk)] > 0; });
    }

    /// Gaps, and what is no origin at all, belong to none.
    std::array<std::int32_t, pixel_origin_count + 1> groups_of_origins() const {
        std::array<std::int32_t, pixel_origin_count + 1> of;
        of.fill(risk_group_count);
        for (int origin = 1; origin < pixel_origin_count; ++origin)
            of[std::size_t(origin)] = int(risk_group(PixelOrigin(origin), job_.numbers.known));
        return of;
    }

    const MapJob& job_;
    int width_, height_, first_;
    RowsAround<float> planar_;
    ClosenessRows closeness_rows_;
    TextureRows texture_rows_;
    Shares shares_;
    RowsAround<float> texture_;
    RowsAround<std::uint8_t> bytes_;
    LossLines loss_;
    formulas::SourceSeen seen_ = seen_from(job_.numbers);
    bool parallax_counts_ = counts(Risk::parallax);
    std::array<std::int32_t, pixel_origin_count + 1> group_of_origin_ = groups_of_origins();
};

void judge_rows_here(const MapJob& job, int first, int last) {
    Judge judge(job, first, last);
    for (int y = first; y < last; ++y)
        judge.row(y);
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(find_differences_here);
HWY_EXPORT(fill_columns_here);
HWY_EXPORT(judge_rows_here);

bool find_differences(const MapJob& job, int first, int last) {
    return HWY_DYNAMIC_DISPATCH(find_differences_here)(job, first, last);
}
void fill_columns(const MapJob& job, int first, int last) {
    HWY_DYNAMIC_DISPATCH(fill_columns_here)(job, first, last);
}
void judge_rows(const MapJob& job, int first, int last) {
    HWY_DYNAMIC_DISPATCH(judge_rows_here)(job, first, last);
}

}  // namespace equistream
#endif
