// Starts the language server of Illuminator, and stops it.

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

function activate() {
  const command = workspace.getConfiguration("illuminator").get("path");
  const documentSelector = [{ language: "illuminator-formula" }, { language: "illuminator-scene" }];
  client = new LanguageClient("illuminator", "Illuminator", { command, args: ["lsp"] }, { documentSelector });
  return client.start();
}

function deactivate() {
  return client?.stop();
}

module.exports = { activate, deactivate };
