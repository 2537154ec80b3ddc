#define BOOST_PROCESS_USE_STD_FS

#include "cli/bench/daemon.h"

#include "common/support/file.h"
#include "common/support/limits.h"

#include <sys/prctl.h>
#include <time.h>

#include <boost/process/args.hpp>
#include <boost/process/child.hpp>
#include <boost/process/env.hpp>
#include <boost/process/environment.hpp>
#include <boost/process/exe.hpp>
#include <boost/process/extend.hpp>
#include <boost/process/io.hpp>

#include <chrono>
#include <csignal>
#include <system_error>
#include <thread>
#include <utility>

namespace lumenfarm {

namespace fs = std::filesystem;
namespace bp = boost::process;

namespace {

constexpr std::uint64_t log_bytes_max = 64u << 20;
constexpr auto look_interval = std::chrono::milliseconds(5);

std::string text_of(const fs::path& log) {
    const auto bytes = read_file(log, log_bytes_max);
    return bytes ? std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()) : std::string();
}

std::string last_line(std::string text) {
    while (text.ends_with('\n')) text.pop_back();
    return text.substr(text.rfind('\n') + 1);
}

bp::environment environment_without_options() {
    bp::environment environment = boost::this_process::environment();
    std::vector<std::string> options;
    for (const auto& entry : environment)
        if (const std::string name = entry.get_name(); name.starts_with("LUMENFARM_")) options.push_back(name);
    for (const std::string& option : options) environment.erase(option);
    return environment;
}

}  // namespace

struct Daemon::Process {
    bp::child child;
};

Daemon::Daemon(std::unique_ptr<Process> process, std::string program, fs::path log)
    : process_(std::move(process)), program_(std::move(program)), log_(std::move(log)) {}

Daemon::~Daemon() { stop(); }

Result<std::unique_ptr<Daemon>> Daemon::start(const std::string& program, std::vector<std::string> arguments,
                                              const fs::path& log) {
    std::error_code error;
    const fs::path path = fs::read_symlink("/proc/self/exe", error).parent_path() / program;
    if (error || !fs::exists(path, error)) return failed("there is no " + program + " beside this program");
    arguments.insert(arguments.end(), {"--config", ""});
    const auto ends_with_us = bp::extend::on_exec_setup([](auto&) { ::prctl(PR_SET_PDEATHSIG, SIGTERM); });
    const auto no_input = bp::std_in < bp::null;
    const auto no_output = bp::std_out > bp::null;
    const auto to_log = bp::std_err > log.string();
    bp::child child(bp::exe = path.string(), bp::args = arguments, environment_without_options(), no_input, no_output,
                    to_log, ends_with_us, error);
    if (error) return failed(program + " can't be started: " + error.message());
    return std::unique_ptr<Daemon>(new Daemon(std::make_unique<Process>(std::move(child)), program, log));
}

Error Daemon::ended() const { return failed(program_ + " ended: " + last_line(text_of(log_))); }

Result<void> Daemon::check_running() const {
    std::error_code ignored;
    if (process_->child.running(ignored)) return {};
    return ended();
}

Result<std::string> Daemon::wait_for(const std::string& begin, const std::string& end) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(limits::connect_seconds);
    for (;;) {
        const bool running = check_running().has_value();
        const std::string text = text_of(log_);
        const auto at = text.find(begin);
        const auto last = at == std::string::npos ? at : text.find(end, at + begin.size());
        if (last != std::string::npos) return text.substr(at + begin.size(), last - at - begin.size());
        if (!running) return ended();
        if (std::chrono::steady_clock::now() > deadline)
            return failed(program_ + " does not start: " + last_line(text));
        std::this_thread::sleep_for(look_interval);
    }
}

double Daemon::cpu_seconds() const {
    clockid_t clock{};
    timespec spent{};
    if (::clock_getcpuclockid(process_->child.id(), &clock) != 0 || ::clock_gettime(clock, &spent) != 0) return 0;
    return static_cast<double>(spent.tv_sec) + 1e-9 * static_cast<double>(spent.tv_nsec);
}

void Daemon::stop() {
    std::error_code ignored;
    if (process_->child.running(ignored)) {
        ::kill(process_->child.id(), SIGTERM);
        ::kill(process_->child.id(), SIGCONT);
    }
    process_->child.wait(ignored);
}

void Daemon::suspend() {
    std::error_code ignored;
    if (process_->child.running(ignored)) ::kill(process_->child.id(), SIGSTOP);
}

}  // namespace lumenfarm
