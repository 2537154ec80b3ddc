#include "cli/commands.h"
#include "cli/options.h"
#include "cli/output_folder.h"
#include "cli/products/measure.h"
#include "common/solution/run_folder.h"

/// `measure`: illuminance at points.
namespace lumenfarm {
namespace {

class MeasureCommand : public Command {
public:
    explicit MeasureCommand(CLI::App& app)
        : Command(app, "measure", "Write the illuminance at points of surfaces, with standard errors") {
        app_.add_option("DIR", path_, "The results' folder")->type_name("")->required();
        text_option(app_, "--points", points_, "Points: rows x,y,z[,nx,ny,nz] in metres")->type_name("CSV")->required();
        text_option(app_, "-o,--output", output_, "Table to write")->type_name("CSV")->required();
    }

    Result<void> execute(Console& console) override {
        if (auto writable = check_file_writable(output_); !writable) return writable;
        const auto run = load_run(path_);
        if (!run) return run.error();
        const auto warnings = measure_file(*run, points_, output_);
        if (!warnings) return warnings.error();
        console.warnings(*warnings);
        console.result("wrote " + output_);
        return {};
    }

private:
    std::string path_;
    std::string points_;
    std::string output_;
};

}  // namespace

std::unique_ptr<Command> make_measure_command(CLI::App& app) { return std::make_unique<MeasureCommand>(app); }

}  // namespace lumenfarm
