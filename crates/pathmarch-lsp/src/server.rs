//! The server: what it can do, and its loop.

use crate::documents::Documents;
use crate::{ServeError, actions, colours, completion, formatting, navigation};
use lsp_server::{Connection, ErrorCode, ExtractError, Message, Notification, Request, Response};
use lsp_types::notification::{self, Notification as _};
use lsp_types::request::{self, Request as _};
use lsp_types::{
    CodeActionKind, CodeActionOptions, CodeActionProviderCapability, ColorProviderCapability, CompletionOptions,
    CompletionResponse, DocumentSymbolResponse, GotoDefinitionResponse, HoverProviderCapability, InitializeParams,
    OneOf, PublishDiagnosticsParams, ServerCapabilities, TextDocumentSyncCapability, TextDocumentSyncKind,
    TextDocumentSyncOptions, Uri,
};
use pathmarch_scene::language_service::OpenText;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Serves an editor over a connection, until it says goodbye.
///
/// # Errors
/// If the editor breaks the protocol or disappears.
pub fn serve(connection: &Connection) -> Result<(), ServeError> {
    let parameters = connection.initialize(serde_json::to_value(capabilities())?)?;
    let mut server = Server::new(&serde_json::from_value(parameters)?);
    while let Ok(message) = connection.receiver.recv() {
        let mut messages = vec![message];
        // What has arrived meanwhile comes before mistakes are published.
        messages.extend(connection.receiver.try_iter());
        for message in messages {
            match message {
                Message::Request(request) if connection.handle_shutdown(&request)? => return Ok(()),
                Message::Request(request) => server.answer(request, connection),
                Message::Notification(notification) => server.note(notification),
                Message::Response(_) => {}
            }
        }
        server.publish(connection);
    }
    Ok(())
}

fn capabilities() -> ServerCapabilities {
    let sync = TextDocumentSyncOptions {
        open_close: Some(true),
        change: Some(TextDocumentSyncKind::INCREMENTAL),
        save: Some(true.into()),
        ..TextDocumentSyncOptions::default()
    };
    let fixes =
        CodeActionOptions { code_action_kinds: Some(vec![CodeActionKind::QUICKFIX]), ..CodeActionOptions::default() };
    let completion = CompletionOptions {
        trigger_characters: Some(["\"", "="].map(str::to_owned).to_vec()),
        ..CompletionOptions::default()
    };
    ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Options(sync)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        completion_provider: Some(completion),
        definition_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        code_action_provider: Some(CodeActionProviderCapability::Options(fixes)),
        color_provider: Some(ColorProviderCapability::Simple(true)),
        document_formatting_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    }
}

struct Server {
    documents: Documents,
    /// True if scenes may read files outside their folder.
    allow_files: bool,
    /// True if the editor understands snippets.
    snippets: bool,
}

impl Server {
    fn new(parameters: &InitializeParams) -> Self {
        let options = parameters.initialization_options.as_ref();
        let allow_files = options.and_then(|options| options.get("allowFiles")?.as_bool()).unwrap_or(false);
        let document = parameters.capabilities.text_document.as_ref();
        let item = document.and_then(|document| document.completion.as_ref()?.completion_item.as_ref());
        let snippets = item.and_then(|item| item.snippet_support).unwrap_or(false);
        Self { documents: Documents::default(), allow_files, snippets }
    }

    fn publish(&mut self, connection: &Connection) {
        for (uri, diagnostics) in self.documents.news() {
            let parameters = PublishDiagnosticsParams { uri, diagnostics, version: None };
            let method = notification::PublishDiagnostics::METHOD.to_owned();
            // Fails only if the editor is gone, which ends the loop.
            let _ = connection.sender.send(Notification::new(method, parameters).into());
        }
    }

    /// Notes what has changed; messages that are not understood are ignored, as the protocol asks.
    fn note(&mut self, notification: Notification) {
        let method = notification.method.clone();
        let _ = match method.as_str() {
            notification::DidOpenTextDocument::METHOD => {
                read::<notification::DidOpenTextDocument>(notification).map(|opened| {
                    let document = opened.text_document;
                    self.documents.open(document.uri, document.text, self.allow_files);
                })
            }
            notification::DidChangeTextDocument::METHOD => read::<notification::DidChangeTextDocument>(notification)
                .map(|changed| self.documents.change(&changed.text_document.uri, changed.content_changes)),
            notification::DidCloseTextDocument::METHOD => read::<notification::DidCloseTextDocument>(notification)
                .map(|closed| self.documents.close(&closed.text_document.uri)),
            notification::DidSaveTextDocument::METHOD | notification::DidChangeWatchedFiles::METHOD => {
                self.documents.refresh();
                Some(())
            }
            _ => None,
        };
    }

    fn answer(&mut self, request: Request, connection: &Connection) {
        let response = self.response(request);
        let _ = connection.sender.send(response.into());
    }

    fn response(&mut self, request: Request) -> Response {
        let snippets = self.snippets;
        match request.method.as_str() {
            request::Completion::METHOD => self.reply::<request::Completion>(request, |documents, asked| {
                let place = asked.text_document_position;
                let open = documents.get(&place.text_document.uri)?;
                Some(CompletionResponse::Array(completion::completions(open, place.position, snippets)))
            }),
            request::HoverRequest::METHOD => self.reply::<request::HoverRequest>(request, |documents, asked| {
                let place = asked.text_document_position_params;
                completion::hover(documents.get(&place.text_document.uri)?, place.position)
            }),
            request::GotoDefinition::METHOD => self.reply::<request::GotoDefinition>(request, |documents, asked| {
                let place = asked.text_document_position_params;
                let uri = place.text_document.uri;
                let location = navigation::definition(&uri, documents.get(&uri)?, place.position)?;
                Some(GotoDefinitionResponse::Scalar(location))
            }),
            request::DocumentSymbolRequest::METHOD => {
                self.reply::<request::DocumentSymbolRequest>(request, |documents, asked| {
                    let symbols = navigation::symbols(documents.get(&asked.text_document.uri)?);
                    Some(DocumentSymbolResponse::Nested(symbols))
                })
            }
            request::CodeActionRequest::METHOD => {
                self.reply::<request::CodeActionRequest>(request, |documents, asked| {
                    let uri = asked.text_document.uri;
                    Some(actions::actions(&uri, documents.get(&uri)?, asked.range))
                })
            }
            request::DocumentColor::METHOD => self.reply::<request::DocumentColor>(request, |documents, asked| {
                of(documents, &asked.text_document.uri, |open| colours::colours(open))
            }),
            request::ColorPresentationRequest::METHOD => {
                self.reply::<request::ColorPresentationRequest>(request, |documents, asked| {
                    let present = |open: &mut OpenText| colours::presentations(open, asked.color, asked.range);
                    of(documents, &asked.text_document.uri, present)
                })
            }
            request::Formatting::METHOD => self.reply::<request::Formatting>(request, |documents, asked| {
                documents.get(&asked.text_document.uri).map(|open| formatting::formatting(open))
            }),
            method => {
                let message = format!("pathmarch does not answer {method}");
                Response::new_err(request.id, ErrorCode::MethodNotFound as i32, message)
            }
        }
    }

    /// Response to a request of this kind.
    fn reply<R: request::Request>(
        &mut self,
        request: Request,
        answer: impl FnOnce(&mut Documents, R::Params) -> R::Result,
    ) -> Response
    where
        R::Params: DeserializeOwned,
        R::Result: Serialize,
    {
        let id = request.id.clone();
        match request.extract::<R::Params>(R::METHOD) {
            Ok((id, asked)) => Response::new_ok(id, answer(&mut self.documents, asked)),
            Err(ExtractError::JsonError { error, .. }) => {
                Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string())
            }
            Err(ExtractError::MethodMismatch(_)) => {
                Response::new_err(id, ErrorCode::InternalError as i32, "another method".to_owned())
            }
        }
    }
}

/// A list about a document; empty if it is not open.
fn of<T>(documents: &mut Documents, uri: &Uri, list: impl FnOnce(&mut OpenText) -> Vec<T>) -> Vec<T> {
    documents.get(uri).map_or_else(Vec::new, list)
}

/// Parameters of a notification; `None` if they are not of its form.
fn read<N: notification::Notification>(notification: Notification) -> Option<N::Params> {
    notification.extract(N::METHOD).ok()
}
