#include "meters.h"

namespace equistream {

void Meter::forget(double now_s) {
    while (!amounts_.empty() && amounts_.front().first <= now_s - window_s_) {
        sum_ -= amounts_.front().second;
        amounts_.pop_front();
    }
    if (amounts_.empty())
        sum_ = 0;  // what rounding left
}

void Meter::add(double now_s, double amount) {
    forget(now_s);
    amounts_.emplace_back(now_s, amount);
    sum_ += amount;
}

double Meter::per_second(double now_s) {
    forget(now_s);
    return sum_ / window_s_;
}

}  // namespace equistream
