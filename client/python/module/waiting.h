#pragma once
/// Calls that may take long: Python's lock is given up, Ctrl-C ends the wait, and a second thread is refused.
#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <nanobind/nanobind.h>

#include <atomic>
#include <functional>
#include <string>

namespace equistream::python {

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
