//! The conversation with an editor: which messages come, and which go back.

use crate::cli::check::diagnostics_of;
use crate::cli::lsp::answers::{AnswerError, answer, parsed};
use crate::cli::lsp::texts::{OpenText, OpenTexts};
use crate::cli::protocol::reports::full_report;
use lsp_server::{ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, Exit, LogMessage, Notification as _, PublishDiagnostics,
};
use lsp_types::request::{Initialize, Request as _, Shutdown};
use lsp_types::{
    CompletionOptions, HoverProviderCapability, InitializeResult, LogMessageParams, MessageType, OneOf, PublishDiagnosticsParams,
    RenameOptions, ServerCapabilities, ServerInfo, TextDocumentSyncCapability, TextDocumentSyncKind, TextDocumentSyncOptions,
    Uri,
};
use serde_json::Value;

/// How far the conversation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum ConversationStage {
    /// The editor has said nothing yet.
    #[default]
    Begun,
    /// Requests are answered.
    Running,
    /// The editor has announced the end.
    ShutDown,
    /// The editor has ended the conversation: after having announced it, or not.
    Exited { properly: bool },
}

/// The state of a conversation.
#[derive(Debug, Default)]
pub(super) struct Server {
    stage: ConversationStage,
    texts: OpenTexts,
    /// Whether the editor shows Markdown.
    markdown: bool,
}

impl Server {
    /// How far the conversation is.
    pub(super) fn stage(&self) -> ConversationStage {
        self.stage
    }

    /// What goes back after a message.
    pub(super) fn take(&mut self, message: Message) -> Vec<Message> {
        match message {
            Message::Request(request) => vec![self.request(request).into()],
            Message::Notification(notification) => self.notification(notification),
            // The server asks nothing.
            Message::Response(_) => Vec::new(),
        }
    }

    fn request(&mut self, request: Request) -> Response {
        let Request { id, method, params } = request;
        let found = match (self.stage, method.as_str()) {
            (ConversationStage::Begun, Initialize::METHOD) => Ok(self.initialize(&params)),
            (ConversationStage::Begun, _) => {
                Err(AnswerError::new(ErrorCode::ServerNotInitialized, "the editor has not said `initialize`"))
            }
            (ConversationStage::Running, Shutdown::METHOD) => {
                self.stage = ConversationStage::ShutDown;
                Ok(Value::Null)
            }
            (ConversationStage::Running, method) => answer(method, params, &self.texts, self.markdown),
            (ConversationStage::ShutDown | ConversationStage::Exited { .. }, _) => {
                Err(AnswerError::new(ErrorCode::InvalidRequest, "the server is shut down"))
            }
        };
        match found {
            Ok(result) => Response::new_ok(id, result),
            Err(AnswerError { code, message }) => Response::new_err(id, code, message),
        }
    }

    /// Begins. Of what the editor tells about itself, only this is read, so that the rest may have any form.
    fn initialize(&mut self, params: &Value) -> Value {
        self.stage = ConversationStage::Running;
        let formats = params.pointer("/capabilities/textDocument/hover/contentFormat").and_then(Value::as_array);
        self.markdown = formats.is_some_and(|formats| formats.iter().any(|format| format == "markdown"));
        let sync = TextDocumentSyncOptions {
            open_close: Some(true),
            change: Some(TextDocumentSyncKind::INCREMENTAL),
            ..TextDocumentSyncOptions::default()
        };
        let rename = RenameOptions { prepare_provider: Some(true), work_done_progress_options: Default::default() };
        let result = InitializeResult {
            capabilities: ServerCapabilities {
                text_document_sync: Some(TextDocumentSyncCapability::Options(sync)),
                completion_provider: Some(CompletionOptions::default()),
                hover_provider: Some(HoverProviderCapability::Simple(true)),
                definition_provider: Some(OneOf::Left(true)),
                references_provider: Some(OneOf::Left(true)),
                document_symbol_provider: Some(OneOf::Left(true)),
                rename_provider: Some(OneOf::Right(rename)),
                document_formatting_provider: Some(OneOf::Left(true)),
                ..ServerCapabilities::default()
            },
            server_info: Some(ServerInfo {
                name: env!("CARGO_PKG_NAME").to_owned(),
                version: Some(env!("CARGO_PKG_VERSION").to_owned()),
            }),
        };
        serde_json::to_value(result).unwrap_or_default()
    }

    fn notification(&mut self, notification: Notification) -> Vec<Message> {
        let Notification { method, params } = notification;
        let outcome = match method.as_str() {
            Exit::METHOD => {
                self.stage = ConversationStage::Exited { properly: self.stage == ConversationStage::ShutDown };
                Ok(None)
            }
            // Before its start and after its end the server heeds no other notifications.
            _ if self.stage != ConversationStage::Running => Ok(None),
            DidOpenTextDocument::METHOD => parsed::<lsp_types::DidOpenTextDocumentParams>(params)
                .map(|opened| Some(published(self.texts.open(opened.text_document)))),
            DidChangeTextDocument::METHOD => parsed::<lsp_types::DidChangeTextDocumentParams>(params).map(|changed| {
                let of = changed.text_document;
                self.texts.change(&of.uri, of.version, changed.content_changes).map(published)
            }),
            DidCloseTextDocument::METHOD => parsed::<lsp_types::DidCloseTextDocumentParams>(params)
                .map(|closed| self.texts.close(&closed.text_document.uri).map(|text| publish(text.uri, Vec::new(), None))),
            // There is nothing to do at others, such as `initialized`.
            _ => Ok(None),
        };
        match outcome {
            Ok(reply) => reply.into_iter().collect(),
            Err(AnswerError { message, .. }) => vec![log(&format!("{method}: {message}"))],
        }
    }
}

/// A line for the log of the editor.
pub(super) fn log(text: &str) -> Message {
    let params = LogMessageParams { typ: MessageType::WARNING, message: text.to_owned() };
    Notification::new(LogMessage::METHOD.to_owned(), params).into()
}

/// The diagnostics of a text, for the editor.
fn published(text: &OpenText) -> Message {
    let (source, positions) = (&text.source, text.positions());
    let diagnostics = diagnostics_of(text.kind(), &text.location(), source);
    let found = diagnostics.iter().map(|one| full_report(one, source, &positions, Some(&text.uri))).collect();
    publish(text.uri.clone(), found, Some(text.version))
}

fn publish(uri: Uri, diagnostics: Vec<lsp_types::Diagnostic>, version: Option<i32>) -> Message {
    let params = PublishDiagnosticsParams { uri, diagnostics, version };
    Notification::new(PublishDiagnostics::METHOD.to_owned(), params).into()
}
