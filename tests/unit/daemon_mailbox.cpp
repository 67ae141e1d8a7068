// SPDX-License-Identifier: Apache-2.0
#include "daemon/mailbox.hpp"
#include "tests/catch.hpp"

#include <atomic>
#include <thread>

using namespace afterglow;

TEST_CASE("a mailbox gives the latest value, again and again") {
    Mailbox<int> mailbox(1);
    CHECK(mailbox.get() == 1);
    mailbox.put(2);
    mailbox.put(3);
    CHECK(mailbox.get() == 3);
    CHECK(mailbox.get() == 3);
    mailbox.put(4);
    CHECK(mailbox.get() == 4);
}

TEST_CASE("a mailbox between two threads never gives half a value, nor an older one", "[tsan]") {
    struct Wide {
        long words[16] = {};
    };
    Mailbox<Wide> mailbox(Wide{});
    constexpr long last = 100'000;
    std::thread producer([&] {
        Wide value;
        for (long n = 1; n <= last; ++n) {
            for (long &word : value.words)
                word = n;
            mailbox.put(value);
        }
    });
    long seen = 0;
    bool whole = true;
    bool in_order = true;
    while (seen < last) {
        const Wide &value = mailbox.get();
        for (const long word : value.words)
            whole = whole && word == value.words[0];
        in_order = in_order && value.words[0] >= seen;
        seen = value.words[0];
    }
    producer.join();
    CHECK(whole);
    CHECK(in_order);
}
