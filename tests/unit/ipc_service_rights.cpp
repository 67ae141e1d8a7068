// SPDX-License-Identifier: Apache-2.0
//
// Who may do what: by groups, and by a polkit of the test's own.
#include "ipc/bus/access.hpp"
#include "ipc/bus/errors.hpp"
#include "tests/bus_service.hpp"
#include "tests/fake_polkit.hpp"
#include "tests/open_descriptors.hpp"
#include "tests/raw_bus_client.hpp"
#include "tests/skip.hpp"

#include <grp.h>
#include <optional>
#include <string>
#include <thread>
#include <vector>

using namespace afterglow;
using namespace afterglow::test;

namespace {

constexpr uid_t stranger = 65534; // nobody: a bus refuses users that the machine does not know

// Groups that every machine has.
const char *const depth_group = "games";
const char *const image_group = "mail";
const char *const control_group = "news";

gid_t id_of(const char *group) {
    const auto *entry = ::getgrnam(group);
    REQUIRE(entry != nullptr);
    return entry->gr_gid;
}

Config by_groups(bool polkit = false) {
    Config config;
    config.access = {depth_group, image_group, control_group, polkit};
    return config;
}

bool may_change_users() {
    if (::geteuid() == 0)
        return true;
    testing::skip("only root can be other users");
    return false;
}

/// What a user of some groups is answered: "" where it is allowed.
struct Visitor {
    BusService &daemon;
    std::vector<gid_t> groups;

    template <class Ask>
    Answer ask(Ask question) const {
        return daemon.serve([&] {
            return as_user(stranger, groups, [&] {
                Client client(daemon.bus.address());
                return question(client);
            });
        });
    }
    std::string open(bool images) const {
        return ask([&](Client &client) {
                   return client.call("OpenStream", "a{sv}", 1, "images", "b", int{images});
               })
            .error;
    }
    std::string control() const {
        return ask([](Client &client) { return client.set("Mode", "s", "off"); }).error;
    }
};

} // namespace

TEST_CASE("groups give rights, and control implies depth", "[ipc]") {
    const Access access({depth_group, image_group, control_group, false});
    Caller caller{.name = ":1.1", .user = stranger, .groups = {id_of(depth_group)}};
    CHECK(access.allows(caller, Right::read_depth));
    CHECK_FALSE(access.allows(caller, Right::see_images));
    CHECK_FALSE(access.allows(caller, Right::control));
    caller.groups = {id_of(control_group)};
    CHECK(access.allows(caller, Right::read_depth));
    CHECK_FALSE(access.allows(caller, Right::see_images));
    CHECK(access.allows(caller, Right::control));
    caller.groups.clear();
    CHECK_FALSE(access.allows(caller, Right::read_depth));
    caller.user = 0;
    CHECK(access.allows(caller, Right::see_images));
    CHECK(access.refusal(Right::see_images) ==
          "You may not see images: that takes the group mail.");
}

TEST_CASE("an empty group is everybody, one that does not exist is nobody", "[ipc]") {
    const Access access({"", "no-such-group", "", false});
    const Caller caller{.name = ":1.1", .user = stranger, .groups = {}};
    CHECK(access.allows(caller, Right::read_depth));
    CHECK_FALSE(access.allows(caller, Right::see_images));
    CHECK(access.allows(caller, Right::control));
    CHECK(access.missing() == std::vector<std::string>{"no-such-group"});
    CHECK(access.refusal(Right::see_images) ==
          "You may not see images: that takes the group no-such-group, which does not exist here.");
}

TEST_CASE("the bus says who a caller is, and each right is asked for by itself", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups());
    const std::string denied = SD_BUS_ERROR_ACCESS_DENIED;
    const Visitor nobody{daemon, {}};
    CHECK(nobody.open(false) == denied);
    CHECK(nobody.control() == denied);
    CHECK(nobody.ask([](Client &client) { return client.call("ListRequests"); }).error.empty());
    CHECK(nobody
              .ask([](Client &client) {
                  return Answer{client.get_string("Mode") == "auto" ? "" : "unreadable", ""};
              })
              .error.empty());

    const Visitor reader{daemon, {stranger, id_of(depth_group)}};
    CHECK(reader.open(false).empty());
    CHECK(reader.open(true) == denied);
    CHECK(reader.control() == denied);

    const Visitor viewer{daemon, {stranger, id_of(depth_group), id_of(image_group)}};
    CHECK(viewer.open(true).empty());
    CHECK(viewer.control() == denied);

    const Visitor controller{daemon, {stranger, id_of(control_group)}};
    CHECK(controller.open(false).empty());
    CHECK(controller.open(true) == denied);
    CHECK(controller.control().empty());
}

TEST_CASE("everything that changes something takes the right to control", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups());
    const Visitor reader{daemon, {stranger, id_of(depth_group)}};
    const auto refused = [&](const char *method, const char *types, auto... arguments) {
        return reader.ask([&](Client &client) { return client.call(method, types, arguments...); })
                   .error == SD_BUS_ERROR_ACCESS_DENIED;
    };
    CHECK(refused("Measure", ""));
    CHECK(refused("RequestAccuracy", "dus", 1.0, 0U, ""));
    CHECK(refused("HoldMode", "ss", "off", ""));
    CHECK(refused("SavePolicy", ""));
    CHECK(refused("Reload", ""));
    CHECK(refused("ResetStatistics", ""));
    const Answer log = reader.ask([](Client &client) {
        return client.answer(sd_bus_set_property(
            client.bus.get(), name, "/org/freedesktop/LogControl1", "org.freedesktop.LogControl1",
            "LogLevel", &client.error, "s", "emerg"));
    });
    CHECK(log.error == SD_BUS_ERROR_ACCESS_DENIED);
    CHECK(log.message == "You may not control the daemon: that takes the group news.");
}

TEST_CASE("a call without interface, or that wants no answer, passes no right by", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups());
    daemon.serve([&] {
        return as_user(stranger, {}, [&] {
            Client client(daemon.bus.address());
            const auto send = [&](const char *interface, bool wants_answer, const char *property) {
                sd_bus_message *call = nullptr;
                sd_bus_message_new_method_call(client.bus.get(), &call, name, path, interface,
                                               "Set");
                sd_bus_message_append(call, "ssv", name, property, "s", "off");
                sd_bus_message_set_expect_reply(call, wants_answer ? 1 : 0);
                sd_bus_call(client.bus.get(), call, 0, nullptr, nullptr);
                sd_bus_message_unref(call);
            };
            send("org.freedesktop.DBus.Properties", false, "Mode");
            send("org.freedesktop.DBus.Properties", true, "Mode");
            send(nullptr, true, "Mode");
            send(nullptr, false, "Mode");
            return client.get_string("Mode");
        });
    });
    CHECK(daemon.control.policies.empty());
}

TEST_CASE("polkit is asked about those whom the groups refuse, once", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups(true));
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::accept);
    const Visitor nobody{daemon, {}};
    const Answer answer = nobody.ask([](Client &client) {
        client.set("Mode", "s", "off");
        client.set("Mode", "s", "interval");
        return client.set("Mode", "s", "always-on");
    });
    CHECK(answer.error.empty());
    CHECK(polkit.asked() == 1);
    CHECK(polkit.last_action() == "org.afterglow.depth1.control");
    CHECK(daemon.control.policies.size() == 3);
    CHECK(nobody.open(true).empty()); // another connection: depth, then images
    CHECK(polkit.asked() == 3);
    CHECK(polkit.last_action() == "org.afterglow.depth1.see-images");

    const Visitor controller{daemon, {stranger, id_of(control_group)}};
    CHECK(controller.control().empty());
    CHECK(polkit.asked() == 3);
}

TEST_CASE("what polkit refuses is refused, once for each connection", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups(true));
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::refuse);
    const Answer answer = Visitor{daemon, {}}.ask([](Client &client) {
        client.set("Mode", "s", "off");
        return client.set("Mode", "s", "off");
    });
    CHECK(answer.error == SD_BUS_ERROR_ACCESS_DENIED);
    CHECK(answer.message == "You may not control the daemon: that takes the group news. Polkit "
                            "does not allow it either.");
    CHECK(polkit.asked() == 1);
}

TEST_CASE("without a decision of polkit the groups' refusal stands", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups(true));
    const std::string denied = SD_BUS_ERROR_ACCESS_DENIED;
    const Visitor nobody{daemon, {}};
    CHECK(nobody.control() == denied); // there is no polkit
    {
        FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::challenge);
        CHECK(nobody.control() == denied);
    }
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::silent);
    SECTION("as it never answers") {
        CHECK(nobody.control() == denied);
    }
    SECTION("as it dies when asked") {
        std::thread killer([&] {
            static_cast<void>(wait_until([&] { return polkit.asked() > 0; }));
            polkit.die();
        });
        CHECK(nobody.control() == denied);
        killer.join();
    }
    CHECK(daemon.control.policies.empty());
}

TEST_CASE("a slow polkit holds up nobody else, and few calls of one sender wait for it", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups(true));
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::silent);
    struct Count {
        int busy = 0, denied = 0;
    } count;
    daemon.serve([&] {
        return as_user(stranger, {}, [&] {
            Client client(daemon.bus.address());
            for (int i = 0; i < 100; ++i)
                sd_bus_call_method_async(
                    client.bus.get(), nullptr, name, path, name, "ResetStatistics",
                    [](sd_bus_message *reply, void *counted, sd_bus_error *) {
                        const sd_bus_error *error = sd_bus_message_get_error(reply);
                        auto &to = *static_cast<Count *>(counted);
                        to.busy += sd_bus_error_has_name(error, error_busy) > 0 ? 1 : 0;
                        to.denied +=
                            sd_bus_error_has_name(error, SD_BUS_ERROR_ACCESS_DENIED) > 0 ? 1 : 0;
                        return 0;
                    },
                    &count, "");
            const auto process = [&] {
                if (sd_bus_process(client.bus.get(), nullptr) == 0)
                    sd_bus_wait(client.bus.get(), 10'000);
            };
            while (count.busy < 92)
                process();
            CHECK(count.denied == 0);
            Client other(daemon.bus.address());
            CHECK(other.get_string("Mode") == "auto");
            while (count.denied < 8)
                process();
            return 0;
        });
    });
    CHECK(count.busy == 92);
}

TEST_CASE("a call that waits for polkit is kept without descriptors", "[ipc]") {
    if (!may_change_users())
        return;
    constexpr int calls = 8, descriptors = 16; // of each: the most that a bus passes on
    BusService daemon(by_groups(true));
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::silent);
    RawBusClient caller =
        as_user(stranger, {}, [&] { return RawBusClient(daemon.bus.address(), geteuid()); });
    const std::size_t before = open_descriptors();
    for (int i = 0; i < calls; ++i)
        caller.call(name, path, name, "ResetStatistics", descriptors);
    // Its messages are in order: the last one is answered, since one more than may wait.
    caller.call(name, path, name, "ResetStatistics", 0);
    daemon.run_until([&] { return caller.receives("You have 8 calls in flight."); });
    daemon.run_until([&] { return polkit.asked() == 1; });
    CHECK(open_descriptors() == before);
}

TEST_CASE("a call that would wait with more than any method takes is refused", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups(true));
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::silent);
    const Visitor visitor{daemon, {}};
    const std::string more(5000, 'x');
    const auto hold = [](const std::string &reason) {
        return [&reason](Client &client) {
            return client.call("HoldMode", "ss", "off", reason.c_str());
        };
    };
    CHECK(visitor.ask(hold(more)).error == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(visitor
              .ask([](Client &client) { return client.call("ResetStatistics", "h", STDIN_FILENO); })
              .error == SD_BUS_ERROR_INVALID_ARGS);
    const auto many_values = [](Client &client) {
        sd_bus_message *call = nullptr;
        sd_bus_message_new_method_call(client.bus.get(), &call, name, path, name,
                                       "ResetStatistics");
        const BusMessage owned(call);
        const std::vector<std::uint8_t> bytes(100);
        sd_bus_message_append_array(call, 'y', bytes.data(), bytes.size());
        sd_bus_error_free(&client.error);
        sd_bus_call(client.bus.get(), call, 0, &client.error, nullptr);
        return Answer{client.error.name == nullptr ? "" : client.error.name, ""};
    };
    CHECK(visitor.ask(many_values).error == SD_BUS_ERROR_INVALID_ARGS);
    CHECK(polkit.asked() == 0);
}

TEST_CASE("a call that has waited has the arguments that it came with", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups(true));
    FakePolkit polkit(daemon.bus.address(), FakePolkit::Behaviour::accept);
    const Visitor visitor{daemon, {}};
    const std::string reason(100, 'x');
    const Answer answer = visitor.ask([&](Client &client) {
        const UniqueFd request = client.hold("RequestAccuracy", "dus", 1.25, 1234U, reason.c_str());
        return Answer{client.error.name == nullptr ? "" : client.error.name, ""};
    });
    CHECK(answer.error.empty());
    REQUIRE_FALSE(daemon.control.policies.empty());
    CHECK(daemon.control.policies.front().target_mre == 1.25);
}

TEST_CASE("who loses a right loses streams and requests, nobody else does", "[ipc]") {
    if (!may_change_users())
        return;
    BusService daemon(by_groups());
    const auto open = [&](std::vector<gid_t> groups, std::uint32_t flags) {
        return daemon.serve([&] {
            return as_user(stranger, groups, [&] {
                afterglow_stream *stream = nullptr;
                open_stream(daemon.bus.address(), &stream, flags);
                return Stream(stream);
            });
        });
    };
    const gid_t depth = id_of(depth_group), images = id_of(image_group),
                control = id_of(control_group);
    const Stream reader = open({depth}, 0);
    const Stream viewer = open({depth, images}, AFTERGLOW_IMAGES);
    const Stream controller = open({control}, 0);
    const UniqueFd held = daemon.serve([&] {
        return as_user(stranger, {control}, [&] {
            return Client(daemon.bus.address()).hold("HoldMode", "ss", "off", "");
        });
    });
    REQUIRE((reader && viewer && controller && held));
    CHECK(daemon.ring.streams().count() == 3);

    Config config = by_groups();
    daemon.service.configure(config);
    CHECK(daemon.ring.streams().count() == 3); // nothing has changed
    config.access.image_group = "no-such-group";
    daemon.service.configure(config);
    CHECK(daemon.ring.streams().count() == 2);
    CHECK(afterglow_wait(viewer.get(), 10'000) == -EACCES);
    config.access.control_group = "no-such-group";
    daemon.service.configure(config);
    CHECK(daemon.ring.streams().count() == 1);
    CHECK(afterglow_wait(controller.get(), 10'000) == -EACCES);
    CHECK(daemon.control.policies.back().mode == GateMode::automatic);
    CHECK(daemon.control.claims.back() == 1);

    daemon.publish();
    CHECK(afterglow_wait(reader.get(), 10'000) == 0);
}
