#include "input_box.h"

#include <chrono>
#include <utility>

namespace equistream {

void InputBox::put(const TakenInputs& inputs) {
    {
        const std::lock_guard lock(mutex_);
        inputs_.samples.insert(inputs_.samples.end(), inputs.samples.begin(), inputs.samples.end());
        inputs_.pressed.insert(inputs_.pressed.end(), inputs.pressed.begin(), inputs.pressed.end());
        inputs_.scroll += inputs.scroll;
        if (inputs.click_x >= 0)
            inputs_.click_x = inputs.click_x;
        inputs_.any = inputs_.any || inputs.any;
        inputs_.is_closed = inputs_.is_closed || inputs.is_closed;
        inputs_.window = inputs.window;
    }
    came_.notify_one();
}

void InputBox::take(TakenInputs& inputs) {
    inputs.samples.clear();
    inputs.pressed.clear();
    const std::lock_guard lock(mutex_);
    std::swap(inputs.samples, inputs_.samples);
    std::swap(inputs.pressed, inputs_.pressed);
    inputs.scroll = std::exchange(inputs_.scroll, 0);
    inputs.click_x = std::exchange(inputs_.click_x, -1);
    inputs.any = std::exchange(inputs_.any, false);
    inputs.is_closed = inputs_.is_closed;
    inputs.window = inputs_.window;
}

void InputBox::wait(double seconds) {
    std::unique_lock lock(mutex_);
    came_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return inputs_.any || inputs_.is_closed; });
}

}  // namespace equistream
