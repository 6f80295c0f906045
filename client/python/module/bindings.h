#pragma once
/// What the parts of the module `equistream._core` share.
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/yuv.h>

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace equistream::python {

// The parts of the module `equistream._core`.

void bind_cameras(nanobind::module_& m);
void bind_patches(nanobind::module_& m);
void bind_motion(nanobind::module_& m);
void bind_frame_info(nanobind::module_& m);
void bind_frames(nanobind::module_& m);
void bind_streams(nanobind::module_& m);
void bind_reprojection(nanobind::module_& m);
void bind_colour(nanobind::module_& m);

// numpy arrays and our images. What goes out owns its samples and is not copied; what comes in is borrowed for a call.

namespace nb = nanobind;

template <typename T>
using ArrayIn = nb::ndarray<const T, nb::ndim<3>, nb::c_contig, nb::device::cpu>;  ///< rows, columns, channels

/// The image's own samples as an array that keeps them alive: rows x columns, and x channels where there are several.
template <typename T>
nb::object to_array(Image<T>&& image) {
    const auto owned = new Image<T>(std::move(image));
    const nb::capsule owner(owned, [](void* p) noexcept { delete static_cast<Image<T>*>(p); });
    const std::size_t shape[] = {static_cast<std::size_t>(owned->height()), static_cast<std::size_t>(owned->width()),
                                 static_cast<std::size_t>(owned->channels())};
    const std::size_t dimensions = owned->channels() == 1 ? 2 : 3;
    return nb::cast(nb::ndarray<nb::numpy, T>(owned->samples().data(), dimensions, shape, owner));
}

/// The package's Python has checked shapes; a caller of the module itself meets nanobind's TypeError.
template <typename T>
ImageView<const T> view_of(const ArrayIn<T>& array) {
    const int width = static_cast<int>(array.shape(1)), channels = static_cast<int>(array.shape(2));
    return {array.data(), width, static_cast<int>(array.shape(0)), channels,
            static_cast<std::ptrdiff_t>(width) * channels};
}

using PlaneIn = nb::ndarray<const std::uint8_t, nb::ndim<2>, nb::device::cpu>;  ///< rows of neighbouring samples
using PlanesIn = std::array<PlaneIn, 3>;                                        ///< Y', Cb, Cr (yuv.h)

inline YuvView view_of(const PlanesIn& planes) {
    const auto view = [](const PlaneIn& plane) {
        return ImageView<const std::uint8_t>{plane.data(), static_cast<int>(plane.shape(1)),
                                             static_cast<int>(plane.shape(0)), 1,
                                             static_cast<std::ptrdiff_t>(plane.stride(0))};
    };
    return {view(planes[0]), view(planes[1]), view(planes[2])};
}

/// A decoder's own planes as three read-only arrays, rows x columns, that keep them alive; nothing is copied.
inline nb::object to_arrays(YuvPicture&& picture) {
    const auto array = [&](const ImageView<const std::uint8_t>& plane) {
        const nb::capsule owner(new YuvPicture(picture), [](void* p) noexcept { delete static_cast<YuvPicture*>(p); });
        const std::size_t shape[] = {static_cast<std::size_t>(plane.height), static_cast<std::size_t>(plane.width)};
        const std::int64_t strides[] = {plane.row_stride, 1};
        return nb::cast(nb::ndarray<nb::numpy, const std::uint8_t>(plane.data, 2, shape, owner, strides));
    };
    return nb::make_tuple(array(picture.planes.y), array(picture.planes.cb), array(picture.planes.cr));
}

template <typename T>
Image<T> copy_of(const ArrayIn<T>& array) {
    const ImageView<const T> view = view_of(array);
    Image<T> image(view.width, view.height, view.channels);
    std::copy_n(view.data, image.samples().size(), image.samples().begin());
    return image;
}

/// A fixed handful of numbers as a read-only array: what a property gives cannot be mistaken for a way to set it.
template <std::size_t N>
nb::object numbers(const double (&values)[N]) {
    auto owned = std::make_unique<double[]>(N);
    std::copy_n(values, N, owned.get());
    const nb::capsule owner(owned.get(), [](void* p) noexcept { delete[] static_cast<double*>(p); });
    const std::size_t shape[] = {N};
    return nb::cast(nb::ndarray<nb::numpy, const double>(owned.release(), 1, shape, owner));
}

// Calls that may take long: Python's lock is given up, Ctrl-C ends the wait, and a second thread is refused.

class Waiting {
public:
    /// `what` is there for one thread at a time; it outlives this.
    explicit Waiting(const char* what) : what_(what) {}

    /// What a source that waits asks now and then: whether Python wants it to stop.
    std::function<bool()> question() {
        return [this] { return is_interrupted(); };
    }

    /// Runs `work` without Python's lock. A signal handler's exception (KeyboardInterrupt) comes before any other.
    template <typename Work>
    void run(const Work& work) {
        if (busy_.exchange(true))
            throw InputError(std::string(what_) + ": expected one thread at a time, found a second one");
        const Idle idle_again{busy_};
        try {
            const nanobind::gil_scoped_release release;
            last_asked_ = Clock::now();
            interrupted_ = false;
            work();
        } catch (...) {
            raise_pending();
            throw;
        }
        raise_pending();
    }

private:
    struct Idle {
        std::atomic<bool>& busy;
        ~Idle() { busy = false; }
    };

    static void raise_pending() {
        if (PyErr_Occurred() != nullptr)
            nanobind::raise_python_error();
    }

    /// Taking the lock costs more than most reads: not more often than a person could notice.
    bool is_interrupted() {
        if (interrupted_ || milliseconds_since(last_asked_) < 50)
            return interrupted_;
        last_asked_ = Clock::now();
        const nanobind::gil_scoped_acquire acquire;
        interrupted_ = PyErr_CheckSignals() != 0;
        return interrupted_;
    }

    const char* what_;
    std::atomic<bool> busy_ = false;
    bool interrupted_ = false;
    Clock::time_point last_asked_;
};

}  // namespace equistream::python
