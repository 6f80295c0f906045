#pragma once
/// A film's storage with more channels in it. A film only lets itself be read whole, be prepared anew and be added to,
/// so that is how: read what a render left, prepare with all channels, add one block that holds them.
///
/// Each pixel is divided by its weight on the way and its weight becomes 1. So whatever is done with the film later (it
/// is developed, written, developed again) divides by 1: values that were put in come out exactly, infinities too,
/// under any reconstruction filter. x * weight / weight would not.
#include "rigid_pose.h"

#include <mitsuba/render/film.h>
#include <mitsuba/render/imageblock.h>

#include <nanothread/nanothread.h>

#include <memory>
#include <string>
#include <vector>

namespace equistream::mitsuba_host {

template <typename Float, typename Spectrum>
class FilmChannels {
public:
    MI_IMPORT_TYPES(Film, ImageBlock)

    /// Throws one line for a film whose storage is not known.
    explicit FilmChannels(Film* film) : film_(film) {
        const std::string kind(film->class_name());
        if (kind != "HDRFilm" && kind != "SpecFilm")
            refuse("equirect_aov: expected a film \"hdrfilm\" or \"specfilm\", found %s", kind);
        weight_is_last_ = kind == "SpecFilm";
        weight_at_ = mitsuba::has_flag(film->flags(), mitsuba::FilmFlags::Alpha) ? 4 : 3;
    }

    /// Whether files of this film hold what its storage holds.
    bool writes_halves() const { return film_->to_string().find("component_format = float16") != std::string::npos; }

    /// Prepares the film with `all` channels, `count` of which are added at their end. `values(x, y, out)` gives those
    /// of a pixel of the crop window, or of arrays of pixels; in scalar variants it is called by many threads.
    template <typename Values>
    void add(const std::vector<std::string>& all, uint32_t count, const Values& values) {
        const TensorXf rendered = film_->develop(true);
        before_ = uint32_t(rendered.shape(2));
        added_ = count;
        if (weight_is_last_)
            weight_at_ = before_ - 1;
        film_->prepare(all);
        mitsuba::ref<ImageBlock> block = film_->create_block();
        block->set_offset(film_->crop_offset());
        if constexpr (dr::is_jit_v<Float>)
            fill_arrays(rendered, *block, values);
        else
            fill_rows(rendered, *block, values);
        film_->put_block(block.get());
    }

private:
    /// Where the added channels begin: the weight of a spectral film stays behind them.
    uint32_t first_added() const { return weight_is_last_ ? before_ - 1 : before_; }
    uint32_t target_of(uint32_t channel) const { return channel < first_added() ? channel : channel + added_; }

    template <typename Values>
    void fill_arrays(const TensorXf& rendered, ImageBlock& block, const Values& values) const {
        const uint32_t width = film_->crop_size().x(), height = film_->crop_size().y(), after = before_ + added_;
        const UInt32 pixel = dr::arange<UInt32>(width * height);
        const UInt32 y = pixel / width, x = dr::fnmadd(y, width, pixel);
        std::vector<Float> added(added_);
        {
            // Geometry planes have no gradients; colour keeps its own.
            dr::suspend_grad<Float> without(true);
            values(x, y, added.data());
        }
        const UInt32 from = pixel * before_, to = pixel * after;
        const Float weight = dr::gather<Float>(rendered.array(), from + weight_at_);
        const Float scale = dr::select(weight != 0.f, dr::rcp(weight), 1.f);
        Float storage = dr::zeros<Float>(size_t(width) * height * after);
        for (uint32_t c = 0; c < before_; ++c)
            dr::scatter(storage,
                        c == weight_at_ ? Float(1.f) : Float(dr::gather<Float>(rendered.array(), from + c) * scale),
                        to + target_of(c));
        for (uint32_t c = 0; c < added_; ++c)
            dr::scatter(storage, added[c], to + (first_added() + c));
        const size_t shape[3] = {height, width, after};
        block.tensor() = TensorXf(storage, 3, shape);
    }

    template <typename Values>
    void fill_rows(const TensorXf& rendered, ImageBlock& block, const Values& values) const {
        const uint32_t width = film_->crop_size().x(), height = film_->crop_size().y(), after = before_ + added_;
        const Float* from = rendered.data();
        Float* to = block.tensor().data();
        dr::parallel_for(dr::blocked_range<uint32_t>(0, height, 2), [&](const dr::blocked_range<uint32_t>& rows) {
            for (uint32_t y = rows.begin(); y != rows.end(); ++y)
                for (uint32_t x = 0; x < width; ++x) {
                    const size_t pixel = size_t(y) * width + x;
                    const Float* in = from + pixel * before_;
                    Float* out = to + pixel * after;
                    const Float scale = in[weight_at_] != 0 ? 1 / in[weight_at_] : 1;
                    for (uint32_t c = 0; c < before_; ++c)
                        out[target_of(c)] = c == weight_at_ ? 1 : in[c] * scale;
                    values(x, y, out + first_added());
                }
        });
    }

    Film* film_;
    bool weight_is_last_ = false;
    uint32_t weight_at_ = 0, before_ = 0, added_ = 0;
};

}  // namespace equistream::mitsuba_host
