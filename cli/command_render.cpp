#include "cli/commands.h"
#include "cli/options.h"
#include "cli/output_folder.h"
#include "cli/products/pictures.h"
#include "common/solution/run_folder.h"
#include "common/support/limits.h"
#include "common/transport/tracer.h"

#include <filesystem>

/// `render`: a view of a result.
namespace lumenfarm {
namespace {

class RenderCommand : public Command {
public:
    explicit RenderCommand(CLI::App& app);
    Result<void> execute(Console& console) override;

private:
    Result<ViewRequest> view_request() const;
    Result<PictureOptions> picture_options() const;

    std::string path_, output_, camera_, size_;
    ViewRequest view_;
    double fov_degrees_ = 0;
    std::uint32_t samples_ = PictureOptions().samples_per_side;
    std::uint32_t threads_ = 0;
    Estimator estimator_ = Estimator::automatic;
};

RenderCommand::RenderCommand(CLI::App& app)
    : Command(app, "render", "Make a picture of a result: EXR with layers, and PNG") {
    app_.add_option("DIR", path_, "The results' folder")->type_name("")->required();
    text_option(app_, "--camera", camera_, "A camera of the scene, by name")->type_name("NAME");
    vector_option(app_, "--look-from", view_.look_from, "Where the eye is, in metres");
    vector_option(app_, "--look-at", view_.look_at, "What it looks at, in metres");
    real_option(app_, "--fov", fov_degrees_, "Vertical angle of view")->type_name("DEGREES")->default_str("45");
    text_option(app_, "--size", size_, "Size in pixels")->type_name("WxH");
    count_option(app_, "--samples", samples_, "Camera rays along one side of a pixel");
    count_option(app_, "--threads", threads_, "Threads; 0 uses all cores");
    choice_option<Estimator>(
        app_, "--estimator", estimator_,
        {{"auto", Estimator::automatic}, {"texels", Estimator::texels}, {"nearest-hits", Estimator::nearest_hits}},
        "Where the light comes from: light maps, or kept hits where there are any");
    text_option(app_, "-o,--output", output_, "Picture to write: .exr (with a .png beside it) or .png")
        ->type_name("FILE")
        ->required();
}

Result<ViewRequest> RenderCommand::view_request() const {
    ViewRequest view = view_;
    if (!camera_.empty()) view.camera = camera_;
    const auto* fov = app_.get_option("--fov");
    if (fov->empty()) return view;
    if (!(fov_degrees_ > 0 && fov_degrees_ < 180))
        return bad_input("--fov is " + fov->as<std::string>() + "; it must be above 0 and below 180 degrees");
    view.fov_degrees = fov_degrees_;
    return view;
}

Result<PictureOptions> RenderCommand::picture_options() const {
    PictureOptions options;
    if (samples_ < 1 || samples_ > limits::samples_per_side_max)
        return bad_input("--samples is " + std::to_string(samples_) + "; it must be from 1 to " +
                         std::to_string(limits::samples_per_side_max));
    if (threads_ > limits::threads_per_worker_max)
        return bad_input("--threads is " + std::to_string(threads_) + "; it must be from 0 to " +
                         std::to_string(limits::threads_per_worker_max));
    options.samples_per_side = samples_;
    options.threads = threads_;
    options.estimator = estimator_;
    if (size_.empty()) return options;
    const auto size = parse_picture_size(size_);
    if (!size) return size.error();
    options.size = *size;
    return options;
}

Result<void> RenderCommand::execute(Console& console) {
    const auto view = view_request();
    if (!view) return view.error();
    const auto options = picture_options();
    if (!options) return options.error();
    const std::filesystem::path output(output_);
    if (output.extension() != ".exr" && output.extension() != ".png")
        return bad_input("'" + output_ + "' ends neither in .exr nor in .png");
    if (auto writable = check_file_writable(output); !writable) return writable;
    const auto run = load_run(path_);
    if (!run) return run.error();
    const auto tracer = TracerScene::make(run->scene);
    if (!tracer) return tracer.error();
    const auto camera = choose_camera(run->scene, **tracer, *view);
    if (!camera) return camera.error();
    if (auto made = render_to(*run, **tracer, *camera, *options, output); !made) return made;
    console.result("wrote " + output_);
    if (output.extension() == ".exr")
        console.result("wrote " + std::filesystem::path(output).replace_extension(".png").string());
    return {};
}

}  // namespace

std::unique_ptr<Command> make_render_command(CLI::App& app) { return std::make_unique<RenderCommand>(app); }

}  // namespace lumenfarm
