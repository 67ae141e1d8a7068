// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace afterglow {

/// Why the world refused: one sentence for a person, and the errno behind it (0 where there is
/// none). Our own bugs are assertions, never Errors.
struct Error {
    std::string message;
    int code = 0;
};

/// A T, or the Error that stood in its way.
template <class T>
class [[nodiscard]] Result {
public:
    Result(T value) : content_(std::move(value)) {}
    Result(Error error) : content_(std::move(error)) {}

    explicit operator bool() const { return content_.index() == 0; }
    T &operator*() & { return value(); }
    const T &operator*() const & { return const_cast<Result *>(this)->value(); }
    T &&operator*() && { return std::move(value()); }
    T *operator->() { return &value(); }
    const T *operator->() const { return &const_cast<Result *>(this)->value(); }
    const Error &error() const {
        assert(!*this);
        return *std::get_if<Error>(&content_);
    }

private:
    T &value() {
        assert(*this);
        return *std::get_if<T>(&content_);
    }
    std::variant<T, Error> content_;
};

/// Success, or the Error that stood in its way.
using Status = Result<std::monostate>;
inline Status ok() {
    return std::monostate{};
}

} // namespace afterglow
