// Starts `pathmarch lsp`, and connects VS Code with it.
"use strict";

const { window, workspace } = require("vscode");
const { LanguageClient, TransportKind } = require("vscode-languageclient/node");

let client;

exports.activate = async function () {
    const settings = workspace.getConfiguration("pathmarch");
    const command = settings.get("program") || "pathmarch";
    const server = { command, args: ["lsp"], transport: TransportKind.stdio };
    const options = {
        documentSelector: [{ language: "pathmarch" }],
        initializationOptions: { allowFiles: settings.get("allowFiles") === true },
        synchronize: { fileEvents: workspace.createFileSystemWatcher("**/*.kdl") },
    };
    client = new LanguageClient("pathmarch", "pathmarch", server, options);
    try {
        await client.start();
    } catch (error) {
        client = undefined;
        window.showErrorMessage(
            `${command} lsp does not start: ${error.message}. Install pathmarch, or set pathmarch.program to its path.`,
        );
    }
};

exports.deactivate = function () {
    return client?.stop();
};
