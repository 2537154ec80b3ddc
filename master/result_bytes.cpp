#include "master/result_bytes.h"

#include "proto/wire_error.h"

#include <optional>
#include <utility>

namespace lumenfarm {

namespace {

Error refusal(wire::WireError error) { return bad_input("a frame of it is refused: " + std::string(name_of(error))); }

/// The messages of one result, one after the other.
class ResultReader {
public:
    ResultReader(JobId job, const JobSpec& spec, const PreparedJob& prepared)
        : job_(job), spec_(spec), prepared_(prepared) {}

    Result<void> take(wire::Message message) {
        return std::visit([&](auto& each) { return take(each); }, message);
    }
    bool complete() const { return complete_; }
    StagedResult result() { return std::move(*result_); }

private:
    template <class Part>
    requires requires(Part part) { part.part; }
    Result<void> take(Part& part) {
        if (complete_ || !of_this(part.part.job, part.part.result)) return bad_input("another result begins in it");
        result_->add(spec_, prepared_, std::move(part));
        return {};
    }
    Result<void> take(wire::ResultDone& done) {
        if (complete_ || !of_this(done.job, done.result)) return bad_input("another result begins in it");
        complete_ = true;
        return result_->complete(prepared_, std::move(done));
    }
    template <class Other>
    Result<void> take(const Other&) {
        return bad_input(std::string(wire::rule_of(Other::type)->name) + " is no part of a result");
    }

    bool of_this(JobId job, std::uint64_t number) {
        if (!result_) result_.emplace(job_, number);
        return job == job_ && number == result_->number();
    }

    JobId job_;
    const JobSpec& spec_;
    const PreparedJob& prepared_;
    std::optional<StagedResult> result_;
    bool complete_ = false;
};

}  // namespace

Result<void> encode_result(const StagedResult& result,
                           const std::function<Result<void>(std::span<const std::byte> frame)>& take) {
    for (const wire::Message& message : result.messages())
        if (const auto taken = take(wire::encode(message)); !taken) return taken;
    return {};
}

Result<StagedResult> decode_result(std::span<const std::byte> bytes, JobId job, const JobSpec& spec,
                                   const PreparedJob& prepared) {
    wire::FrameParser parser({wire::from_worker, {}});
    ResultReader reader(job, spec, prepared);
    while (!bytes.empty()) {
        auto frame = parser.consume(bytes);
        if (!frame) return refusal(frame.error());
        if (!*frame) break;
        auto message = wire::decode((*frame)->header.type, (*frame)->payload);
        if (!message) return refusal(message.error());
        if (const auto taken = reader.take(std::move(*message)); !taken) return taken.error();
    }
    if (!reader.complete() || !parser.at_boundary()) return bad_input("it is cut short");
    return reader.result();
}

}  // namespace lumenfarm
