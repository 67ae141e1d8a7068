// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tests/catch.hpp"

#include <string>

using afterglow::printable;

TEST_CASE("text of a user is quoted without control characters") {
    CHECK(printable("") == "");
    CHECK(printable("a b~") == "a b~");
    CHECK(printable("\x1b[31mred\x1b[0m") == "\\x1b[31mred\\x1b[0m");
    CHECK(printable("a\nb\tc\r\x7f") == "a\\nb\\tc\\x0d\\x7f");
    CHECK(printable(std::string("\0", 1)) == "\\x00");
}

TEST_CASE("UTF-8 of a user is quoted as it is, and what is not UTF-8 is escaped") {
    CHECK(printable("Gr\xc3\xb6\xc3\x9f"
                    "e \xe2\x82\xac \xf0\x9f\x94\xa6") == "Gr\xc3\xb6\xc3\x9f"
                                                          "e \xe2\x82\xac \xf0\x9f\x94\xa6");
    CHECK(printable("\xff\xc3") == "\\xff\\xc3");
    CHECK(printable("\xc3(") == "\\xc3(");
    CHECK(printable("\xc2\x9b") == "\\xc2\\x9b");            // U+009B starts an escape sequence too
    CHECK(printable("a\xe2\x80\xae") == "a\\xe2\\x80\\xae"); // U+202E turns what follows around
    CHECK(printable("\xe2\x80\x94") == "\xe2\x80\x94");
}

TEST_CASE("of long text of a user only beginning and end are quoted") {
    CHECK(printable(std::string(200, 'a')) == std::string(200, 'a'));
    CHECK(printable(std::string(2'000'000, 'a') + "/file") ==
          std::string(120, 'a') + "..." + std::string(55, 'a') + "/file");
    CHECK(printable(std::string(200, '\x1b')).size() < 200);
    std::string umlauts;
    for (int i = 0; i < 1000; ++i)
        umlauts += "\xc3\xb6";
    for (const char *before : {"", "a"})
        CHECK(printable(before + umlauts).find("\\x") == std::string::npos);
}
