//! Jobs for farms that run the Open Job Description, specification `jobtemplate-2023-09`.

use crate::cli::farm::description::JobDescription;
use crate::cli::report::Failure;
use illuminator::lang::diagnostic::Diagnostic;
use serde_json::json;

/// What the shell does with the folder, the program and its arguments. Actions have no folder of their own.
const IN_FOLDER: &str = "cd \"$1\" && shift && exec \"$@\"";

/// Names have at most this many characters.
const LONGEST_NAME: usize = 128;

/// The template of a job, as JSON.
///
/// # Errors
/// An argument cannot be written.
pub(super) fn text(job: &JobDescription) -> Result<String, Failure> {
    // What is between them is an expression, and there is no way to escape it.
    if let Some(argument) = job.arguments.iter().find(|argument| argument.contains("{{")) {
        let message = format!("`{argument}` has `{{{{`, which job templates cannot hold");
        return Err(Failure::CommandLine(Diagnostic::error(message).help("give the file another name")));
    }
    let action = |last: &[&str]| {
        let fixed = ["-c", IN_FOLDER, "sh", "{{Param.Folder}}", "{{Param.Program}}"];
        let arguments: Vec<&str> =
            fixed.into_iter().chain(job.arguments.iter().map(String::as_str)).chain(last.to_vec()).collect();
        let cancelation = json!({ "mode": "NOTIFY_THEN_TERMINATE" });
        json!({ "actions": { "onRun": { "command": "sh", "args": arguments, "cancelation": cancelation } } })
    };
    let part = format!("{{{{Task.Param.Part}}}}/{}", job.parts);
    let mut folder = json!({
        "name": "Folder",
        "type": "PATH",
        "objectType": "DIRECTORY",
        "dataFlow": "INOUT",
        "description": format!("The folder that paths start from, with the input and the output: {}", job.folder),
    });
    if job.is_beside {
        folder["default"] = json!(".");
    }
    let template = json!({
        "specificationVersion": "jobtemplate-2023-09",
        "name": job.name.chars().take(LONGEST_NAME).collect::<String>(),
        "parameterDefinitions": [
            folder,
            {
                "name": "Program",
                "type": "STRING",
                "description": "The program on the workers: a path, or `illuminator` where it is installed",
                "default": job.program,
            },
        ],
        "steps": [
            {
                "name": "Parts",
                "parameterSpace": {
                    "taskParameterDefinitions": [{ "name": "Part", "type": "INT", "range": format!("1-{}", job.parts) }],
                },
                "script": action(&["--part", &part]),
            },
            {
                "name": "Merge",
                "dependencies": [{ "dependsOn": "Parts" }],
                "script": action(&["--merge"]),
            },
        ],
    });
    Ok(format!("{:#}\n", template))
}
