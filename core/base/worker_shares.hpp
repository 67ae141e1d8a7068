// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/worker_pool.hpp"

#include <cstddef>
#include <vector>

namespace afterglow {

/// What each worker of a pool makes of its parts of a job, in a T of its own: so no two write to
/// one place. Which parts went where must not be seen in what all shares together are. Allocates
/// when made.
template <class T>
class WorkerShares {
public:
    WorkerShares(const WorkerPool &pool, const T &share)
        : shares_(static_cast<std::size_t>(pool.size()), Share{share}) {}

    /// A new job: nobody has used a share.
    void begin() {
        for (Share &share : shares_)
            share.used = false;
    }
    /// A worker's share; clear(share) makes it empty before its first use.
    template <class Clear>
    T &use(int worker, const Clear &clear) {
        Share &share = shares_[static_cast<std::size_t>(worker)];
        if (!share.used)
            clear(share.value);
        share.used = true;
        return share.value;
    }
    /// The caller's, to which the others are added.
    T &first() { return shares_.front().value; }
    const T &first() const { return shares_.front().value; }
    /// Calls visit(share) for each of the others that was used.
    template <class Visit>
    void for_each_other(const Visit &visit) const {
        for (std::size_t worker = 1; worker < shares_.size(); ++worker)
            if (shares_[worker].used)
                visit(shares_[worker].value);
    }

private:
    struct Share {
        T value;
        bool used = false;
    };
    std::vector<Share> shares_;
};

} // namespace afterglow
