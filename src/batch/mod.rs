//! Many sessions: discovery, parallel work, tables.
