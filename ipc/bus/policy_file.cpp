// SPDX-License-Identifier: Apache-2.0
#include "ipc/bus/policy_file.hpp"

#include "core/base/write_file.hpp"
#include "ipc/bus/call_copy.hpp"
#include "ipc/bus/errors.hpp"

#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <system_error>

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <string_view>
#include <unistd.h>
#include <utility>

namespace afterglow {
namespace {

/// Writes a file that its owner alone can read, and that is there after a power failure, too.
Status write_durably(const std::string &path, std::string_view text) {
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    const UniqueFd opened(
        ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    Result<OutputFile> file = OutputFile::open(path, 0600);
    if (!file)
        return file.error();
    if (!write_all(file->fd(), text) || ::fsync(file->fd()) < 0)
        return file->error();
    if (Status finished = file->finish(); !finished)
        return finished;
    // The new name lasts, too.
    if (::fsync(opened.get()) < 0) {
        const int error = errno;
        return Error{fmt::format("{} is written, but may be the old one after a power failure: {}",
                                 path, std::strerror(error)),
                     error};
    }
    return ok();
}

} // namespace

PolicyFile::PolicyFile(sd_event *event, std::string path)
    : path_(std::move(path)), written_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    sd_event_source *source = nullptr;
    if (written_ && sd_event_add_io(event, &source, written_.get(), EPOLLIN, on_written, this) >= 0)
        source_.reset(source);
}

PolicyFile::~PolicyFile() {
    if (thread_.joinable())
        thread_.join();
}

int PolicyFile::save(sd_bus_message *call, std::string text) {
    if (path_.empty())
        return sd_bus_reply_method_errorf(call, error_no_policy_file,
                                          "The daemon was started without --policy FILE.");
    if (!source_)
        return -EMFILE;
    if (saves_.size() >= most_calls)
        return sd_bus_reply_method_errorf(call, error_busy, "%zu calls wait for the disk.",
                                          saves_.size());
    BusMessage kept;
    if (const int error = copy_call(call, kept); error < 0)
        return error;
    saves_.push_back({std::move(kept), std::move(text)});
    if (saves_.size() == 1)
        begin();
    return 1;
}

void PolicyFile::forget_callers() {
    for (Save &save : saves_)
        save.call.reset();
}

void PolicyFile::begin() {
    try {
        thread_ = std::thread([this, text = saves_.front().text] {
            result_ = write_durably(path_, text);
            ::eventfd_write(written_.get(), 1);
        });
    } catch (const std::system_error &refused) {
        result_ = Error{path_ + " cannot be written: " + refused.what(), refused.code().value()};
        ::eventfd_write(written_.get(), 1);
    }
}

int PolicyFile::on_written(sd_event_source * /*source*/, int fd, std::uint32_t /*events*/,
                           void *file) {
    auto &self = *static_cast<PolicyFile *>(file);
    ::eventfd_t count = 0;
    ::eventfd_read(fd, &count);
    if (self.thread_.joinable())
        self.thread_.join();
    if (const BusMessage call = std::move(self.saves_.front().call))
        self.answer(call.get());
    self.saves_.pop_front();
    if (!self.saves_.empty())
        self.begin();
    return 0;
}

void PolicyFile::answer(sd_bus_message *call) const {
    if (result_)
        sd_bus_reply_method_return(call, "s", path_.c_str());
    else
        sd_bus_reply_method_errorf(call, SD_BUS_ERROR_FAILED, "%s",
                                   result_.error().message.c_str());
}

} // namespace afterglow
